#include <exception>
#include <new>
#include <string>

#include <CLI/CLI.hpp>

#include "apps/commands/command.h"
#include "apps/console/console.h"
#include "apps/console/exit_status.h"
#include "apps/console/interruption.h"
#include "apps/version.h"
#include "relief/scan/context.h"

namespace relief {
namespace {

// Of the chosen command, whose option it is.
int threads_of(const CLI::App& app) {
  const CLI::Option* threads = app.get_subcommands().front()->get_option_no_throw("--threads");
  return threads ? threads->as<int>() : 0;
}

// On its threads, until a signal asks it to stop.
int carry_out(const Action& action, int threads) {
  Context context;
  context.threads = threads;
  context.stop = interruption();
  int status = kDone;
  if (!run_until_stopped(context, [&] { status = action(); }))
    return fail({ErrorKind::kInterrupted, "stopped on request"});
  return status;
}

}  // namespace
}  // namespace relief

int main(int argc, char** argv) {
  using namespace relief;
  CLI::App app{"relief: range scans and normal maps to one watertight model", "relief"};
  app.set_version_flag("--version", std::string("relief ") + kVersion);
  app.require_subcommand(1);
  app.option_defaults()->always_capture_default();

  Action action;
  constexpr AddCommand kCommands[] = {add_info,     add_align,    add_calibrate, add_refine,
                                      add_merge,    add_run,      add_step,      add_plan,
                                      add_simulate, add_evaluate, add_compare,   add_convert,
                                      add_init,     add_render,   add_report,    add_clean};
  for (const AddCommand add : kCommands) add(app, action);

  const auto is_chosen = [&](const CLI::App* command) { return command->check_name(argv[1]); };
  if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(is_chosen).empty())
    return fail({ErrorKind::kBadInput,
                 std::string("no command `") + argv[1] + "`: relief --help lists the commands"});

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kWrongUsage;
  }

  catch_interrupts();
  try {
    return carry_out(action, threads_of(app));
  } catch (const std::bad_alloc&) {
    return fail({ErrorKind::kUnsolvable,
                 "out of memory: reduce the number or the resolution of the views, or give a "
                 "larger voxel size"});
  } catch (const std::exception& error) {
    return fail({ErrorKind::kUnsolvable, std::string("internal error: ") + error.what()});
  }
}
