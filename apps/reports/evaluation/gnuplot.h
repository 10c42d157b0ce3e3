#pragma once

#include <filesystem>
#include <string>

#include "relief/scan/result.h"

namespace relief {

/// Writes `script` as `<name>.gp` into `folder` and has gnuplot run it there, so that it may name
/// its data and pictures without a folder. kCannotWrite when gnuplot is missing or fails: the
/// script and the data stay, to be drawn by hand.
Result<void> run_gnuplot(const std::filesystem::path& folder, const std::string& name,
                         const std::string& script);

/// Text as it must stand in a script to appear as it is.
std::string gnuplot_text(const std::string& text);

}  // namespace relief
