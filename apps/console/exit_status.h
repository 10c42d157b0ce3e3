#pragma once

#include "relief/scan/result.h"

namespace relief {

/// What the program tells the shell.
enum ExitStatus : int {
  kDone = 0,
  kDataDoesNotAllow = 1,  ///< What was achieved is kept.
  kWrongUsage = 2,        ///< Wrong options, unreadable input, unwritable output.
  kInterrupted = 130,
};

inline int exit_status(const Error& error) {
  switch (error.kind) {
    case ErrorKind::kUnsolvable:
      return kDataDoesNotAllow;
    case ErrorKind::kInterrupted:
      return ExitStatus::kInterrupted;
    case ErrorKind::kBadInput:
    case ErrorKind::kCannotWrite:
      return kWrongUsage;
  }
  return kWrongUsage;
}

}  // namespace relief
