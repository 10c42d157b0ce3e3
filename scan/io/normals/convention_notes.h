#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "scan/io/normals/normal_evidence.h"

namespace relief {

/// The lines that tell the user about conventions of normals. Views with the same line share it.
class ConventionNotes {
 public:
  /// `certain`: no other convention fits as well.
  void add_choice(const NormalEvidence& view, const NormalConvention& chosen, bool certain);
  /// A curve was undone.
  void add_curve(const NormalEvidence& view);
  /// The normals are `bias` [rad] off even in the best convention.
  void add_unusable(const NormalEvidence& view, const NormalConvention& best, double bias);

  /// `views`: how many there are, so that all of them need not be named.
  std::vector<std::string> texts(std::size_t views) const;

 private:
  struct Note {
    std::string text, angle_name;
    std::vector<std::string> views;
    std::vector<double> angles;           // [rad] in the chosen convention, by view,
    std::vector<double> declared_angles;  // and in the declared one where that is another.
  };
  Note& find(const std::string& text, const std::string& angle_name);

  std::vector<Note> notes_;
};

/// `encoding rgb, axes opengl, space camera`.
std::string name_of(const NormalEvidence& view, const NormalConvention& convention);

/// `12.3 deg`.
std::string degrees_text(double angle);

}  // namespace relief
