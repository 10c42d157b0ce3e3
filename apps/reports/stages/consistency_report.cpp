#include "apps/reports/stages/consistency_report.h"

#include <cstddef>

#include <fmt/format.h>

#include "apps/console/console.h"

namespace relief {

namespace {

double percentage(const reconstruction::ViewConsistency& view) {
  if (view.compared == 0) return 0.0;
  return 100.0 * static_cast<double>(view.contradicted) / static_cast<double>(view.compared);
}

}  // namespace

Json consistency_report(const std::vector<reconstruction::ViewConsistency>& consistency,
                        const std::vector<RangeView>& views) {
  Json list = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i)
    list.push_back({{"name", views[i].name},
                    {"samples_compared", consistency[i].compared},
                    {"samples_contradicted", consistency[i].contradicted},
                    {"samples_corrected", consistency[i].corrected},
                    {"deviation", consistency[i].deviation}});
  return {{"views", list}};
}

void log_consistency(const std::vector<reconstruction::ViewConsistency>& consistency,
                     const std::vector<RangeView>& views, const std::string& unit, double seconds) {
  constexpr double kWorthSaying = 1.0;  // [%]
  reconstruction::ViewConsistency all;
  for (std::size_t i = 0; i < views.size(); ++i) {
    all.contradicted += consistency[i].contradicted;
    all.corrected += consistency[i].corrected;
    all.compared += consistency[i].compared;
    const std::string line = fmt::format(
        "{}: other views contradict {:.2g} % of its ranges, which count less (typical deviation "
        "{:.3g} {})",
        views[i].name, percentage(consistency[i]), consistency[i].deviation, unit);
    if (percentage(consistency[i]) >= kWorthSaying) Console::detail(line);
  }
  if (all.compared == 0) return;
  Console::info(fmt::format(
      "compared {} samples with other views in {:.1f} s: {:.2g} % are contradicted and count less, "
      "{} of them are corrected",
      all.compared, seconds, percentage(all), all.corrected));
}

}  // namespace relief
