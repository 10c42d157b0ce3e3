#include "apps/console/console.h"

#include <cstdio>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

namespace relief {

namespace {

bool status_open = false;  // A status stands on the terminal's current line.
bool as_json = false;

spdlog::logger& logger() {
  static const std::shared_ptr<spdlog::logger> instance = [] {
    auto created = std::make_shared<spdlog::logger>(
        "relief", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    created->set_pattern("%^%v%$");
    return created;
  }();
  return *instance;
}

void log(spdlog::level::level_enum level, const char* name, const std::string& message) {
  Console::end_status();
  if (as_json) {
    const nlohmann::ordered_json line{{"level", name}, {"message", message}};
    // What is no UTF-8, in a file's name, is replaced.
    logger().log(level, "{}", line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (level >= spdlog::level::warn) {
    logger().log(level, "{}: {}", name, message);
  } else {
    logger().log(level, "{}", message);
  }
}

}  // namespace

void Console::set_verbosity(Verbosity verbosity) {
  logger().set_level(verbosity == Verbosity::kQuiet     ? spdlog::level::err
                     : verbosity == Verbosity::kVerbose ? spdlog::level::debug
                                                        : spdlog::level::info);
}

bool Console::quiet() { return logger().level() > spdlog::level::info; }

void Console::set_json(bool json) { as_json = json; }

void Console::info(const std::string& message) { log(spdlog::level::info, "info", message); }
void Console::detail(const std::string& message) { log(spdlog::level::debug, "detail", message); }
void Console::warning(const std::string& message) { log(spdlog::level::warn, "warning", message); }
void Console::error(const std::string& message) { log(spdlog::level::err, "error", message); }

void Console::status(const std::string& line) {
  fmt::print(stderr, "\r{}", line);
  std::fflush(stderr);
  status_open = true;
}

void Console::end_status() {
  if (status_open) fmt::print(stderr, "\n");
  status_open = false;
}

void Console::json_line(const std::string& object) {
  fmt::print(stderr, "{}\n", object);
  std::fflush(stderr);
}

}  // namespace relief
