#include "apps/reports/html/page_frame.h"

#include "apps/reports/html/html_text.h"
#include "apps/reports/html/page_assets.h"
#include "apps/version.h"

namespace relief {

std::string fill_page(const PageParts& parts) {
  std::string sections;
  for (const std::string& section : parts.sections)
    sections += (&section == &parts.sections.front() ? "" : "\n") + section;
  const std::string figures = parts.figures.dump(-1, ' ', true, Json::error_handler_t::replace);
  return fill_template(page_assets::page_html(), {{"title", escape_html(parts.title)},
                                                  {"kind", parts.kind},
                                                  {"style", std::string(page_assets::style_css())},
                                                  {"sections", sections},
                                                  {"version", kVersion},
                                                  {"exact", parts.exact},
                                                  {"credit", parts.credit},
                                                  {"report", escape_script_json(figures)},
                                                  {"scripts", parts.scripts}});
}

}  // namespace relief
