#include "scan/io/normals/convention_notes.h"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "scan/base/median.h"
#include "scan/base/name_list.h"

namespace relief {

std::string degrees_text(double angle) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f deg", angle * 180.0 / std::numbers::pi);
  return text;
}

std::string name_of(const NormalEvidence& view, const NormalConvention& convention) {
  const std::string axes = to_string(convention, view.kind);
  if (view.kind == NormalFileKind::kGrid) return axes;
  return std::string("encoding ") + (view.encoding == NormalEncoding::kRgb ? "rgb" : "unit") +
         ", " + axes;
}

ConventionNotes::Note& ConventionNotes::find(const std::string& text,
                                             const std::string& angle_name) {
  const auto found = std::find_if(notes_.begin(), notes_.end(),
                                  [&](const Note& note) { return note.text == text; });
  if (found != notes_.end()) return *found;
  notes_.push_back({text, angle_name, {}, {}, {}});
  return notes_.back();
}

void ConventionNotes::add_choice(const NormalEvidence& view, const NormalConvention& chosen,
                                 bool certain) {
  const bool as_declared = view.declared && chosen == view.usual.front();
  if (as_declared && certain) return;
  const std::string name = name_of(view, chosen);
  std::string text;
  if (!view.declared)
    text = "normals found to be " + name;
  else if (as_declared)
    text = "normals taken as declared, " + name;
  else
    text = "warning: the depth contradicts normals of " + name_of(view, view.usual.front()) +
           " as declared; they are used as " + name;
  if (!certain)
    text +=
        ", but other conventions fit as well: the surface is too flat, too noisy or too small "
        "to tell them apart";
  Note& note = find(text, "median angle to the depth");
  note.views.push_back(view.view);
  if (view.patches.patches.empty()) return;
  note.angles.push_back(agreement(view, chosen).median);
  if (view.declared && !as_declared)
    note.declared_angles.push_back(agreement(view, view.usual.front()).median);
}

void ConventionNotes::add_curve(const NormalEvidence& view) {
  const bool srgb = view.curve == TransferCurve::kSrgb || view.curve == TransferCurve::kSrgbLinear;
  const bool encoded = view.curve == TransferCurve::kSrgb || view.curve == TransferCurve::kPower;
  const std::string curve = srgb ? "sRGB" : "2.2";
  Note& note = find((encoded ? "normals are stored with the gamma of colours (" + curve + ")"
                             : "normals are stored as colours without their gamma (" + curve +
                                   "), which rounds dark values") +
                        ": it is undone, which gives them unit length; export normal maps as data, "
                        "not as colours",
                    "median angle to the depth");
  note.views.push_back(view.view);
}

void ConventionNotes::add_unusable(const NormalEvidence& view, const NormalConvention& best,
                                   double bias) {
  Note& note =
      find("warning: the normals are not used: in the best convention, " + name_of(view, best) +
               ", they are off by more than " + degrees_text(kLargestBias) +
               " beyond the noise of the depth; check the lights of the photometric "
               "stereo, the scale of the depth and the camera, and whether the depth is smoother "
               "than the surface",
           "median");
  note.views.push_back(view.view);
  note.angles.push_back(bias);
}

namespace {

std::string names_text(const std::vector<std::string>& names, std::size_t all) {
  if (names.size() == all && all > 2) return "all " + std::to_string(all) + " views with normals";
  return (names.size() > 1 ? "views " : "view ") + name_list(names);
}

}  // namespace

std::vector<std::string> ConventionNotes::texts(std::size_t views) const {
  std::vector<std::string> all;
  for (const Note& note : notes_) {
    std::string line = names_text(note.views, views);
    line += ": " + note.text;
    if (!note.angles.empty()) {
      line += " (" + note.angle_name + " " + degrees_text(median(std::vector(note.angles)));
      if (!note.declared_angles.empty())
        line += ", as declared " + degrees_text(median(std::vector(note.declared_angles)));
      line += ")";
    }
    all.push_back(line);
  }
  return all;
}

}  // namespace relief
