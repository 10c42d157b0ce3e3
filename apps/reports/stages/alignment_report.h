#pragma once

#include <string>

#include "apps/reports/report.h"
#include "relief/reconstruction/alignment_gain.h"
#include "relief/registration/align_views.h"

namespace relief {

/// The section `align` of the report.
Json to_json(const registration::Alignment& alignment);

/// The entry `gain` of the section `align_again`.
Json to_json(const reconstruction::AlignmentGain& gain);

/// Logs what was found, `seconds` after the start: the notes, the table of pairs where it can be
/// taken in at a glance (else with -v), and a line on the whole.
void log_alignment(const registration::Alignment& alignment, const std::string& unit,
                   double seconds);

/// Warns of the views that are not verified, once of those with the same reason.
void warn_of_unverified(const registration::Alignment& alignment);

/// Logs what aligning again on refined views changed.
void log_gain(const reconstruction::AlignmentGain& gain, const std::string& unit);

}  // namespace relief
