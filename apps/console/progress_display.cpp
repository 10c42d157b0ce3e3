#include "apps/console/progress_display.h"

#include <cmath>
#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "apps/console/console.h"
#include "apps/console/interruption.h"
#include "scan/base/stopwatch.h"

namespace relief {

namespace {

std::string in_minutes(double seconds) {
  const long long whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

// What the computations tell, as it is shown.
class ProgressDisplay {
 public:
  static ProgressDisplay& instance() {
    static ProgressDisplay display;
    return display;
  }

  void set_format(ProgressFormat format) {
    if (format == ProgressFormat::kAuto)
      format = isatty(STDERR_FILENO) != 0 ? ProgressFormat::kBar : ProgressFormat::kLines;
    format_ = format;
    Console::set_json(format == ProgressFormat::kJson);
  }

  void plan(std::vector<PlannedStage> stages) {
    whole_ = !stages.empty();
    plan_ = ProgressPlan(std::move(stages));
  }

  void show(const std::string& stage, double fraction, std::string_view step) {
    const double overall = plan_.overall(stage, step, fraction);
    const Event event{stage, std::string(step), fraction, overall, watch_.seconds()};
    const bool new_step = event.stage != last_.stage || event.step != last_.step;
    switch (format_) {
      case ProgressFormat::kBar:
        return show_bar(event, new_step);
      case ProgressFormat::kLines:
        return show_line(event, new_step);
      case ProgressFormat::kJson:
        return show_json(event, new_step);
      case ProgressFormat::kAuto:
      case ProgressFormat::kOff:
        return;
    }
  }

 private:
  struct Event {
    std::string stage, step;
    double fraction = 0.0, overall = 0.0, seconds = 0.0;
  };

  void show_bar(const Event& event, bool new_step) {
    constexpr double kOften = 0.1;  // [s]
    const bool ends = event.fraction >= 1.0 && !whole_;
    if (!new_step && !ends && event.seconds < last_.seconds + kOften) return;
    constexpr int kWidth = 24;
    const int filled = static_cast<int>(event.overall * kWidth);
    Console::status(fmt::format("[{:=<{}}{:<{}}] {:3.0f} % {:<7} {}: {:<36.36}", "", filled, "",
                                kWidth - filled, 100.0 * event.overall, left(event), event.stage,
                                event.step));
    if (ends) Console::end_status();
    last_ = event;
  }

  // A quarter of a stage, a tenth of a plan, or half a minute: a log stays readable.
  void show_line(const Event& event, bool new_step) {
    constexpr double kLong = 30.0;  // [s]
    const double parts = whole_ ? 10.0 : 4.0;
    const bool further = std::floor(event.overall * parts) > std::floor(last_.overall * parts);
    const std::string line =
        fmt::format("{:>7} {:3.0f} % {}: {}{}", in_minutes(event.seconds), 100.0 * event.overall,
                    event.stage, event.step, left(event).empty() ? "" : ", " + left(event));
    if (further || event.seconds > last_.seconds + kLong)
      Console::info(line);
    else if (new_step)
      Console::detail(line);
    else
      return;
    last_ = event;
  }

  void show_json(const Event& event, bool new_step) {
    constexpr double kOften = 0.2;  // [s]
    if (!new_step && event.seconds < last_.seconds + kOften && event.fraction < 1.0) return;
    nlohmann::ordered_json line{{"seconds", event.seconds},
                                {"stage", event.stage},
                                {"step", event.step},
                                {"stage_fraction", event.fraction},
                                {"fraction", event.overall}};
    if (const double rest = plan_.seconds_left(event.seconds); rest >= 0.0)
      line["seconds_left"] = rest;
    Console::json_line(line.dump());
    last_ = event;
  }

  std::string left(const Event& event) const {
    const double rest = plan_.seconds_left(event.seconds);
    return whole_ && rest >= 0.0 ? in_minutes(rest) + " left" : "";
  }

  ProgressFormat format_ = ProgressFormat::kLines;
  ProgressPlan plan_;
  bool whole_ = false;  // Whether the plan is of a whole command.
  Stopwatch watch_;
  Event last_;
};

}  // namespace

void set_progress_format(ProgressFormat format) { ProgressDisplay::instance().set_format(format); }

void plan_progress(std::vector<PlannedStage> stages) {
  ProgressDisplay::instance().plan(std::move(stages));
}

Progress console_progress(const std::string& stage) {
  return [stage](double fraction, std::string_view step) {
    if (interruption().stop_requested()) return false;
    if (!Console::quiet()) ProgressDisplay::instance().show(stage, fraction, step);
    return true;
  };
}

reconstruction::StageProgress console_stage_progress() {
  return [](reconstruction::Stage stage, double fraction, std::string_view step) {
    return console_progress(std::string(to_string(stage)))(fraction, step);
  };
}

}  // namespace relief
