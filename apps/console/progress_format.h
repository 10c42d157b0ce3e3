#pragma once

namespace relief {

/// How progress is shown on standard error.
enum class ProgressFormat {
  kAuto,   ///< A bar on a terminal, else lines.
  kBar,    ///< Of the whole command, with the time left.
  kLines,  ///< With the time since the start.
  kJson,   ///< One object a line, messages as well.
  kOff,
};

}  // namespace relief
