#include "apps/reports/html/report_figures.h"

#include <cmath>

#include <fmt/format.h>

#include "apps/reports/html/html_text.h"

namespace relief {

namespace {

std::string rounded(const Json& value, Rounding rounding) {
  const double number = value.get<double>();
  switch (rounding) {
    case Rounding::kCount:
      if (number >= 0.0 && number < 1e15 && number == std::floor(number))
        return grouped(static_cast<std::uint64_t>(number));
      return fmt::format("{}", number);
    case Rounding::kThreeDigits:
      return three_digits(number);
    case Rounding::kPercent:
      return three_digits(100.0 * number) + "\u202f%";
  }
  return "";
}

}  // namespace

std::string three_digits(double value) {
  // Whole numbers as they are: 1234 reads better than 1.23e+03.
  const double size = std::abs(value);
  if (size == 0.0) return "0";
  if (size >= 100.0 && size < 1e6) return fmt::format("{:.0f}", value);
  return fmt::format("{:#.3g}", value);
}

std::string shown_number(const Json& number, const std::string& place, Rounding rounding,
                         const std::string& unit) {
  return fmt::format(R"(<data value="{}" data-key="{}">{}</data>{})", number.dump(), place,
                     rounded(number, rounding),
                     unit.empty() ? std::string() : "&nbsp;" + escape_html(unit));
}

const Json* ReportFigures::find(const std::string& place) const {
  const Json::json_pointer pointer(place);
  return report_.contains(pointer) ? &report_.at(pointer) : nullptr;
}

std::optional<double> ReportFigures::number(const std::string& place) const {
  const Json* found = find(place);
  if (!found || !found->is_number()) return std::nullopt;
  return found->get<double>();
}

std::string ReportFigures::text(const std::string& place) const {
  const Json* found = find(place);
  return found && found->is_string() ? found->get<std::string>() : "";
}

std::optional<bool> ReportFigures::truth(const std::string& place) const {
  const Json* found = find(place);
  if (!found || !found->is_boolean()) return std::nullopt;
  return found->get<bool>();
}

std::size_t ReportFigures::size(const std::string& place) const {
  const Json* found = find(place);
  return found && found->is_array() ? found->size() : 0;
}

std::vector<std::string> ReportFigures::entries(const std::string& place) const {
  std::vector<std::string> places(size(place));
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = place + "/" + std::to_string(i);
  return places;
}

std::string ReportFigures::alignment() const {
  return truth("/align_again/gain/kept").value_or(false) ? "/align_again" : "/align";
}

std::string ReportFigures::entry_of(const std::string& place, const std::string& name) const {
  for (const std::string& entry : entries(place)) {
    const Json* found = find(entry + "/name");
    if (found && *found == name) return entry;
  }
  return "";
}

std::string ReportFigures::shown(const std::string& place, Rounding rounding,
                                 const std::string& unit) const {
  const Json* found = find(place);
  return found && found->is_number() ? shown_number(*found, place, rounding, unit) : "–";
}

}  // namespace relief
