#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/reports/html/report_figures.h"
#include "apps/reports/html/view_grades.h"
#include "apps/reports/html/viewer/model_statistics.h"
#include "apps/reports/html/viewer/view_camera.h"
#include "apps/reports/html/viewer/viewer_model.h"

namespace relief {

/// A picture for the page.
struct ReportPicture {
  std::string title;
  std::string png;  ///< The bytes of the file.
};

/// All that the page of a report shows.
struct ReportContent {
  ReportFigures report;
  std::string name;           ///< Of the folder.
  std::string unit = "unit";  ///< Of the lengths.
  std::vector<GradedView> views;
  std::vector<ViewCamera> cameras;
  InitialViewpoint viewpoint;  ///< At the model, in the viewer and in the pictures.
  std::optional<ModelStatistics> model;
  std::optional<ViewerModel> viewer;
  std::string no_viewer;  ///< Why there is no model to look at.
  std::vector<ReportPicture> pictures;
  std::map<std::string, std::vector<ReportPicture>> view_pictures;  ///< By the names of the views.
  std::vector<std::string> source_names;  ///< Of the views by their indices in the model.
};

/// A <figure> with the picture and its title.
std::string picture_figure(const ReportPicture& picture);

/// The sections of the page, each a <section> of HTML. A section that has nothing to say is empty.
std::string summary_section(const ReportContent& content);
std::string pictures_section(const ReportContent& content);
std::string views_section(const ReportContent& content);
std::string alignment_section(const ReportContent& content);
std::string model_section(const ReportContent& content);
std::string provenance_section(const ReportContent& content);

}  // namespace relief
