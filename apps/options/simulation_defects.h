#pragma once

#include <CLI/CLI.hpp>

#include "apps/reports/report.h"
#include "relief/simulation/simulate.h"

namespace relief {

/// What a command line asks to be wrong with the scans.
struct DefectChoice {
  simulation::ScanDefects defects;
  bool background = false;
  simulation::BackgroundPlate plate;
  bool glare = false;
  simulation::Glare highlights;
  /// Whether the written project says which axes and space the normal maps have.
  bool undeclared_normals = false;

  /// kBadInput when a parameter of plate or glare is given without it.
  Result<simulation::ScanDefects> chosen() const;
};

/// Adds --background, --missing and the other defects that every sensor may have.
void add_defect_options(CLI::App& command, DefectChoice& choice);

/// The defects as an object of truth.json; null when there are none.
Json defects_json(const simulation::ScanDefects& defects, bool undeclared_normals);

}  // namespace relief
