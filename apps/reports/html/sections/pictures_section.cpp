#include <algorithm>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/report_content.h"

namespace relief {

std::string picture_figure(const ReportPicture& picture) {
  return fmt::format(
      "<figure><img src=\"data:image/png;base64,{}\" alt=\"{}\" "
      "loading=\"lazy\"><figcaption>{}</figcaption></figure>\n",
      base64(picture.png), escape_html(picture.title), escape_html(picture.title));
}

std::string pictures_section(const ReportContent& content) {
  if (content.pictures.empty()) return "";
  std::string html = fmt::format(
      "<section id=\"pictures\"><h2>Pictures</h2>\n<p>The model from {}, drawn without WebGL.</p>\n"
      "<div class=\"pictures\">\n",
      std::any_of(content.cameras.begin(), content.cameras.end(),
                  [](const ViewCamera& camera) { return camera.direction.has_value(); })
          ? "the direction of the view that saw most of it"
          : "one side");
  for (const ReportPicture& picture : content.pictures) html += picture_figure(picture);
  return html + "</div></section>\n";
}

}  // namespace relief
