#include "apps/reports/html/views/view_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "apps/console/picture_file.h"
#include "apps/reports/html/views/shaded_samples.h"
#include "scan/base/parallel.h"
#include "scan/io/files/atomic_file.h"

namespace relief {

namespace {

// A picture of 240 pixels has about 50 kB: those of 24 views come to 3 MB in a page of at most 15.
// More views share that. Below 60 pixels nothing can be made out.
constexpr double kPictureWidth = 240.0, kViewsAtThatWidth = 24.0, kLeastPictureWidth = 60.0;

int width_for(std::size_t views) {
  const double most = kPictureWidth * std::sqrt(kViewsAtThatWidth / static_cast<double>(views));
  return most < kLeastPictureWidth ? 0 : static_cast<int>(std::min(kPictureWidth, most));
}

std::vector<rendering::Picture> draw_all(const std::vector<RangeView>& views, int width) {
  return parallel_map<rendering::Picture>(
      views.size(), [&](std::size_t i) { return shaded_samples(views[i], width); });
}

// Its place within the folder.
Result<std::string> write_one(const rendering::Picture& picture,
                              const std::filesystem::path& folder, std::size_t view,
                              const std::string& kind) {
  const std::string place = fmt::format("pictures/{:03}-{}.png", view, kind);
  if (auto done = write_picture(picture, rendering::Background::kWhite, kind, folder / place);
      !done)
    return done.error();
  return place;
}

}  // namespace

void ViewPictures::draw_measured(const std::vector<RangeView>& views) {
  width_ = width_for(views.size());
  if (width_ == 0) return;
  std::vector<rendering::Picture> pictures = draw_all(views, width_);
  for (std::size_t i = 0; i < views.size(); ++i) measured_[views[i].name] = std::move(pictures[i]);
}

Result<void> ViewPictures::write(const std::vector<RangeView>& views,
                                 const std::vector<hybrid::RefineSummary>& refinements,
                                 const std::filesystem::path& folder, Json& section) const {
  if (width_ == 0) return {};
  std::error_code failed;
  std::filesystem::create_directories(folder / "pictures", failed);
  if (failed)
    return Error{ErrorKind::kCannotWrite, (folder / "pictures").string() + ": " + failed.message()};
  const std::vector<rendering::Picture> refined = draw_all(views, width_);
  for (std::size_t i = 0; i < views.size(); ++i) {
    Json& places = section["views"][i]["pictures"] = Json::object();
    const auto add = [&](const rendering::Picture& picture, const char* kind) -> Result<void> {
      auto place = write_one(picture, folder, i, kind);
      if (!place) return place.error();
      places[kind] = std::move(*place);
      return {};
    };
    if (const auto found = measured_.find(views[i].name); found != measured_.end())
      if (auto done = add(found->second, "measured"); !done) return done;
    if (refinements[i].status != hybrid::RefineStatus::kRefined) continue;
    if (auto done = add(refined[i], "refined"); !done) return done;
  }
  return {};
}

std::string named_picture(const std::filesystem::path& folder, const std::string& place) {
  constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
  const std::filesystem::path path(place);
  if (place.empty() || path.is_absolute()) return "";
  for (const auto& part : path)
    if (part == "..") return "";
  const auto bytes = read_file(folder / path);
  return bytes && bytes->starts_with(kSignature) ? *bytes : "";
}

}  // namespace relief
