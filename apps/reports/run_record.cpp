#include "apps/reports/run_record.h"

#include <string>

namespace relief {

namespace {

// Option groups are nameless commands within the command.
void add_given(const CLI::App& command, Json& options) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    std::string values;
    for (const std::string& value : option->results())
      values += (values.empty() ? "" : " ") + value;
    options["--" + option->get_lnames().front()] = values;
  }
  for (const CLI::App* group : command.get_subcommands(nullptr))
    if (group->get_name().empty()) add_given(*group, options);
}

}  // namespace

Json run_record(const std::filesystem::path& input, const CLI::App& command) {
  Json options = Json::object();
  add_given(command, options);
  return {{"input", input.string()}, {"options", std::move(options)}};
}

}  // namespace relief
