#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "scan/io/files/atomic_file.h"
#include "scan/io/project/guess/folder_guess.h"

namespace relief {

namespace {

struct InitCommand {
  CommonOptions common;
  ProjectInput input;
  std::filesystem::path output;
};

int init(const InitCommand& command) {
  const std::filesystem::path output =
      command.output.empty() ? command.input.path / "scan.json" : command.output;
  std::error_code code;
  if (std::filesystem::exists(output, code))
    return fail({ErrorKind::kBadInput,
                 output.string() + ": exists already; move it away, or name another with -o"});
  const auto guess = guess_project(command.input.path, command.input.options);
  if (!guess) return fail(guess.error());
  const auto folder = output.has_parent_path() ? output.parent_path() : std::filesystem::path(".");
  const auto written = write_file(output, commented_scan_json(*guess, folder));
  if (!written) return fail(written.error());
  for (const std::string& line : guess->findings) Console::info(line);
  for (const std::string& line : guess->missing) Console::info("to fill in: " + line);
  for (const std::string& line : guess->unreadable) Console::info("cannot be read: " + line);
  const std::size_t unreadable = guess->unreadable.size();
  Console::info("wrote " + output.string() + ": " + std::to_string(guess->project.views.size()) +
                " views" +
                (unreadable > 0 ? ", of which " + std::to_string(unreadable) + " cannot be read"
                                : std::string()));
  return kDone;
}

}  // namespace

void add_init(CLI::App& app, Action& action) {
  auto command = std::make_shared<InitCommand>();
  auto* sub = app.add_subcommand(
      "init", "Look at a folder of unknown files and write a commented scan.json to correct");
  sub->add_option("folder", command->input.path, "The folder")->required();
  add_reading_options(*sub, command->input.options);
  sub->add_option("-o,--output", command->output, "The file; default: FOLDER/scan.json");
  add_common_options(*sub, command->common);
  sub->callback([command, &action] { action = [command] { return init(*command); }; });
}

}  // namespace relief
