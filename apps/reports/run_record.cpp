#include "apps/reports/run_record.h"

#include <cstddef>
#include <string>
#include <utility>

#include "scan/base/parallel.h"
#include "scan/units/content_hash.h"
#include "scan/units/input_hash.h"

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
  return {
      {"input", input.string()}, {"program", program_identity()}, {"options", std::move(options)}};
}

Json input_record(const std::vector<RangeView>& views) {
  const auto samples = parallel_map<std::string>(
      views.size(), [&](std::size_t i) { return hash_of_samples(views[i]); });
  Json list = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    ContentHash pose;
    pose.add(views[i].world_from_view, views[i].pose);
    list.push_back(
        {{"name", views[i].name}, {"samples_sha256", samples[i]}, {"pose_sha256", pose.hex()}});
  }
  return list;
}

}  // namespace relief
