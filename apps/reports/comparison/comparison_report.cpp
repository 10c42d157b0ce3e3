#include "apps/reports/comparison/comparison_report.h"

#include <cmath>

#include "apps/reports/evaluation/evaluation_report.h"

namespace relief {

namespace {

Json text_or_null(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json number_or_null(const std::optional<double>& number) { return number ? Json(*number) : Json(); }

Json side_report(const RunSide& side) {
  return {{"folder", side.folder},
          {"version", text_or_null(side.version)},
          {"program", text_or_null(side.program)},
          {"input", text_or_null(side.input)},
          {"finished", side.finished},
          {"missing", side.missing}};
}

Json option_report(const ComparedOption& option) {
  return {{"name", option.name},
          {"a", option.a ? Json(*option.a) : Json()},
          {"b", option.b ? Json(*option.b) : Json()},
          {"changes_result", option.changes_result}};
}

Json figure_report(const ComparedFigure& figure, const std::string& length) {
  Json report = {{"unit", unit_of(figure.quantity, length)},
                 {"a", json_of(figure.quantity, figure.a)},
                 {"b", json_of(figure.quantity, figure.b)}};
  if (figure.quantity == Quantity::kTruth) return report;
  report["difference"] = json_of(figure.quantity, figure.difference());
  report["ratio"] = number_or_null(figure.ratio());
  return report;
}

Json view_report(const ComparedView& view) {
  Json report = {
      {"name", view.name},
      {"input", to_string(view.input)},
      {"status", {{"a", text_or_null(view.a.alignment)}, {"b", text_or_null(view.b.alignment)}}},
      {"refinement",
       {{"a", text_or_null(view.a.refinement)}, {"b", text_or_null(view.b.refinement)}}},
      {"rms_change",
       {{"a", number_or_null(view.a.rms_change)}, {"b", number_or_null(view.b.rms_change)}}},
      {"median_deviation",
       {{"a", number_or_null(view.a.median_deviation)},
        {"b", number_or_null(view.b.median_deviation)}}}};
  report["pose"] = view.pose ? Json({{"rotation_deg", view.pose->rotation_deg},
                                     {"translation", view.pose->translation},
                                     {"mean_displacement", view.pose->mean_displacement},
                                     {"rms_displacement", view.pose->rms_displacement}})
                             : Json();
  return report;
}

Json frame_report(const FrameMotion& frame) {
  return {{"fitted", frame.views > 0},
          {"views", frame.views},
          {"a_from_b", to_json(frame.a_from_b)},
          {"rotation_deg", frame.rotation_deg},
          {"shift", frame.shift}};
}

Json pose_report(const evaluation::PoseErrorReport& poses) {
  return {{"views", poses.views.size()},
          {"mean_rotation_deg", poses.mean_rotation_deg},
          {"max_rotation_deg", poses.max_rotation_deg},
          {"mean_translation", poses.mean_translation},
          {"max_translation", poses.max_translation},
          {"mean_displacement", poses.mean_displacement},
          {"rms_displacement", poses.rms_displacement},
          {"max_displacement", poses.max_displacement}};
}

Json model_report(const ComparedModels& models) {
  return {{"a_to_b", to_json(models.distances.a_to_b)},
          {"b_to_a", to_json(models.distances.b_to_a)},
          {"thresholds", models.distances.thresholds},
          {"colour_scale", models.colour_scale}};
}

}  // namespace

Json json_of(Quantity quantity, const std::optional<double>& value) {
  if (!value) return {};
  if (quantity == Quantity::kCount) return std::llround(*value);
  if (quantity == Quantity::kTruth) return *value != 0.0;
  return *value;
}

std::string unit_of(Quantity quantity, const std::string& length) {
  switch (quantity) {
    case Quantity::kLength:
      return length;
    case Quantity::kArea:
      return length.empty() ? "" : length + "²";
    case Quantity::kVolume:
      return length.empty() ? "" : length + "³";
    case Quantity::kAngle:
      return "deg";
    case Quantity::kTime:
      return "s";
    case Quantity::kMemory:
      return "MB";
    case Quantity::kCount:
    case Quantity::kNumber:
    case Quantity::kFraction:
    case Quantity::kTruth:
      return "";
  }
  return "";
}

Json to_json(const RunComparison& comparison) {
  Json report = {{"a", side_report(comparison.a)},
                 {"b", side_report(comparison.b)},
                 {"complete", comparison.complete()},
                 {"unit", text_or_null(comparison.unit)},
                 {"notes", comparison.notes},
                 {"options", Json::array()},
                 {"figures", Json::object()},
                 {"frame", frame_report(comparison.frame)},
                 {"poses", Json()},
                 {"views", Json::array()},
                 {"models", Json()}};
  for (const ComparedOption& option : comparison.options)
    report["options"].push_back(option_report(option));
  for (const ComparedFigure& figure : comparison.figures)
    report["figures"][figure.group][figure.key] = figure_report(figure, comparison.unit);
  if (comparison.poses) report["poses"] = pose_report(*comparison.poses);
  for (const ComparedView& view : comparison.views) report["views"].push_back(view_report(view));
  if (comparison.models) report["models"] = model_report(*comparison.models);
  return report;
}

}  // namespace relief
