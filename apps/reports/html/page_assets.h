#pragma once

#include <string_view>

/// The files of apps/reports/html/page and of three.js, as embed_files.cmake puts them into the
/// program.
namespace relief::page_assets {

std::string_view page_html();    ///< The frame of a page, with places as `{{sections}}`.
std::string_view viewer_html();  ///< The section with the viewer and its controls.
std::string_view style_css();
std::string_view model_js();
std::string_view scene_js();
std::string_view viewer_js();
std::string_view three_js();  ///< With its licence as first comment.
std::string_view orbit_controls_js();

}  // namespace relief::page_assets
