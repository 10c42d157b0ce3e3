#include "apps/reports/evaluation/gnuplot.h"

#include <cerrno>
#include <cstring>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scan/io/files/atomic_file.h"

namespace relief {

Result<void> run_gnuplot(const std::filesystem::path& folder, const std::string& name,
                         const std::string& script) {
  std::string file = name + ".gp";
  if (auto written = write_file(folder / file, script); !written) return written;
  const auto failed = [&](const std::string& why) {
    return Error{ErrorKind::kCannotWrite, (folder / file).string() + ": " + why +
                                              "; script and data are kept, to be drawn by hand"};
  };
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, folder.c_str());
  std::string program = "gnuplot";
  char* const arguments[] = {program.data(), file.data(), nullptr};
  pid_t child = 0;
  const int problem = posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (problem == ENOENT)
    return failed("plots need the program gnuplot, which is not installed (package gnuplot-nox)");
  if (problem != 0) return failed(std::string("cannot start gnuplot: ") + std::strerror(problem));
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return failed("gnuplot was lost");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return failed("gnuplot failed");
  return {};
}

std::string gnuplot_text(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace relief
