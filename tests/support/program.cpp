#include "tests/support/program.h"

#include <algorithm>
#include <csignal>
#include <fstream>
#include <sstream>
#include <system_error>

#include <fcntl.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace relief::testing {

namespace {

// For this process and its children only.
bool mount_over(const std::filesystem::path& folder, const char* place) {
  return unshare(CLONE_NEWNS) == 0 &&
         mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
         mount(folder.c_str(), place, nullptr, MS_BIND, nullptr) == 0;
}

[[noreturn]] void become_program(std::vector<char*> arguments, const std::string& out,
                                 const std::string& err, const ProgramLimits& limits) {
  const int out_file = open(out.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
  const int err_file = open(err.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
  dup2(out_file, STDOUT_FILENO);
  dup2(err_file, STDERR_FILENO);
  if (limits.file_size_bytes >= 0) {
    std::signal(SIGXFSZ, SIG_IGN);  // writing then fails with EFBIG
    const auto bytes = static_cast<rlim_t>(limits.file_size_bytes);
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  if (!limits.control_groups.empty() && !mount_over(limits.control_groups, "/sys/fs/cgroup"))
    _exit(ProgramLimits::kNotPermitted);
  execv(arguments[0], arguments.data());
  _exit(127);
}

// Starts the program, lets `wait` see to its end, and gathers what it left.
ProgramRun run_program(const std::vector<std::string>& arguments, const ProgramLimits& limits,
                       const std::function<int(pid_t)>& wait) {
  const TemporaryFolder folder;
  const std::string out = folder / "out", err = folder / "err";
  std::string program = RELIEF_PROGRAM;
  std::vector<std::string> owned = arguments;
  std::vector<char*> argv{program.data()};
  for (std::string& argument : owned) argv.push_back(argument.data());
  argv.push_back(nullptr);

  const pid_t child = fork();
  if (child == 0) become_program(argv, out, err, limits);
  const int status = wait(child);
  ProgramRun run;
  run.exit_status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.standard_output = read_text(out);
  run.standard_error = read_text(err);
  return run;
}

}  // namespace

ProgramRun run_relief(const std::vector<std::string>& arguments, const ProgramLimits& limits) {
  return run_program(arguments, limits, [](pid_t child) {
    int status = 0;
    waitpid(child, &status, 0);
    return status;
  });
}

ProgramRun run_relief_until(const std::function<bool()>& enough,
                            const std::vector<std::string>& arguments, int signal) {
  return run_program(arguments, {}, [&](pid_t child) {
    int status = 0;
    while (waitpid(child, &status, WNOHANG) == 0) {
      if (!enough()) {
        usleep(1000);
        continue;
      }
      kill(child, signal);
      waitpid(child, &status, 0);
      break;
    }
    return status;
  });
}

std::vector<std::string> files_below(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  if (!std::filesystem::exists(folder)) return names;
  // A program that runs beside the test may remove a file between its listing and any question.
  std::error_code gone;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file(gone))
      names.push_back(entry.path().lexically_relative(folder).string());
  std::sort(names.begin(), names.end());
  return names;
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace relief::testing
