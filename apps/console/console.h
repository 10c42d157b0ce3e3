#pragma once

#include <string>

#include "relief/reconstruction/build_model.h"
#include "relief/scan/progress.h"
#include "relief/scan/result.h"

namespace relief {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// Messages and progress on standard error; results never go there.
class Console {
 public:
  static void set_verbosity(Verbosity verbosity);

  /// For the user's log; kept when not quiet.
  static void info(const std::string& message);
  static void detail(const std::string& message);  ///< Only with -v.
  static void warning(const std::string& message);
  static void error(const std::string& message);
};

/// A progress callback for one stage: a bar on a terminal, otherwise a line per step and per
/// quarter. It asks the computation to stop after Ctrl-C or a termination signal.
Progress console_progress(const std::string& stage);

/// The same for a computation of several stages.
reconstruction::StageProgress console_stage_progress();

/// From now on Ctrl-C and termination ask for an orderly stop; a second one ends the program at
/// once.
void catch_interrupts();

}  // namespace relief
