#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "apps/reports/report.h"
#include "relief/hybrid/refine_view.h"
#include "relief/rendering/picture.h"
#include "relief/scan/range_view.h"
#include "relief/scan/result.h"

namespace relief {

/// Pictures of the views of a run as measured and as refined, for its page.
class ViewPictures {
 public:
  /// Draws the views as they were measured. Many views get small pictures; beyond some hundreds
  /// none.
  void draw_measured(const std::vector<RangeView>& views);

  /// Draws `views`, of which `refinements` tells, and writes the pictures into
  /// `folder`/pictures. Notes their places in the entries `views` of `section`, that of refining,
  /// as `pictures/measured` and `pictures/refined`. Errors: kCannotWrite.
  Result<void> write(const std::vector<RangeView>& views,
                     const std::vector<hybrid::RefineSummary>& refinements,
                     const std::filesystem::path& folder, Json& section) const;

 private:
  int width_ = 0;                                       // [pixels]; 0: no pictures.
  std::map<std::string, rendering::Picture> measured_;  // By the names of the views.
};

/// The bytes of a picture that a report names; empty if it names none inside `folder`, or the file
/// is no PNG.
std::string named_picture(const std::filesystem::path& folder, const std::string& place);

}  // namespace relief
