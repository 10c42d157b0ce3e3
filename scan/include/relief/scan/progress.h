#pragma once

#include <functional>
#include <string_view>

namespace relief {

/// Told how far a long computation is: `fraction` in [0, 1] of the step named by `step`.
/// Returning false asks the computation to stop; it then returns ErrorKind::kInterrupted.
/// Called from the thread that started the computation only.
using Progress = std::function<bool(double fraction, std::string_view step)>;

/// Calls `progress` if there is one; true means go on.
inline bool report_progress(const Progress& progress, double fraction, std::string_view step) {
  return !progress || progress(fraction, step);
}

}  // namespace relief
