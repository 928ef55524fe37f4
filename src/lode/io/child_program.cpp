#include "lode/io/child_program.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <sstream>
#include <system_error>
#include <utility>

namespace lode::io {

std::optional<std::string> find_program(const std::string& name) {
  std::error_code status;
  const auto own = std::filesystem::read_symlink("/proc/self/exe", status);
  std::vector<std::filesystem::path> folders;
  if (!status) folders.push_back(own.parent_path());
  const char* const path = std::getenv("PATH");
  std::istringstream list(path == nullptr ? "" : path);
  for (std::string folder; std::getline(list, folder, ':');)
    if (!folder.empty()) folders.emplace_back(folder);
  for (const std::filesystem::path& folder : folders) {
    const std::string program = (folder / name).string();
    if (std::filesystem::is_regular_file(program, status) && ::access(program.c_str(), X_OK) == 0)
      return program;
  }
  return {};
}

Result<ChildProgram> ChildProgram::start(const std::vector<std::string>& words, ChildErrors errors,
                                         int passed) {
  constexpr int kPassed = 3;
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0)
    return fail("{}: cannot be started: {}", words[0], std::strerror(errno));
  // Above those that the program gets, of which some may be free.
  const int written = ::fcntl(ends[1], F_DUPFD_CLOEXEC, kPassed + 1);
  const int given = passed >= 0 ? ::fcntl(passed, F_DUPFD_CLOEXEC, kPassed + 1) : -1;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_adddup2(&actions, written, STDOUT_FILENO);
  if (errors == ChildErrors::read)
    ::posix_spawn_file_actions_adddup2(&actions, written, STDERR_FILENO);
  else
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  if (passed >= 0) ::posix_spawn_file_actions_adddup2(&actions, given, kPassed);
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  pid_t process = -1;
  const int status =
      ::posix_spawn(&process, words[0].c_str(), &actions, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  for (const int end : {ends[1], written, given})
    if (end >= 0) ::close(end);
  if (status == 0) return ChildProgram(process, ends[0]);
  ::close(ends[0]);
  return fail("{}: cannot be started: {}", words[0], std::strerror(status));
}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
    : process_(std::exchange(other.process_, -1)),
      output_(std::exchange(other.output_, -1)),
      text_(std::move(other.text_)) {}

ChildProgram::~ChildProgram() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    wait();
  }
  if (output_ >= 0) ::close(output_);
}

Result<std::optional<std::string>> ChildProgram::read_line(
    const Progress& progress, std::optional<std::chrono::milliseconds> patience) {
  constexpr int kGlanceMs = 100;
  constexpr std::size_t kMostBytes = std::size_t{4} << 20;
  std::array<char, 4096> part{};
  // Of glances, not of time: what was stopped with its parent was not silent meanwhile.
  std::chrono::milliseconds silence{0};
  std::size_t n_seen = 0;
  while (true) {
    if (progress.is_cancelled()) return cancelled_error();
    const std::size_t end = text_.find('\n', n_seen);
    if (end != std::string::npos) {
      std::string line = text_.substr(0, end);
      text_.erase(0, end + 1);
      return std::optional(std::move(line));
    }
    n_seen = text_.size();
    if (n_seen > kMostBytes) return fail("expected lines of up to 4 MiB, got a longer one");
    if (patience && silence > *patience)
      return fail("no word for {} s",
                  std::chrono::duration_cast<std::chrono::seconds>(*patience).count());
    pollfd waiting{.fd = output_, .events = POLLIN, .revents = 0};
    const int n_ready = ::poll(&waiting, 1, kGlanceMs);
    if (n_ready == 0) silence += std::chrono::milliseconds(kGlanceMs);
    if (n_ready == 0 || (n_ready < 0 && errno == EINTR)) continue;
    const ssize_t n = ::read(output_, part.data(), part.size());
    if (n < 0 && errno == EINTR) continue;
    if (n > 0) {
      text_.append(part.data(), static_cast<std::size_t>(n));
      silence = {};
      continue;
    }
    if (text_.empty()) return std::optional<std::string>();
    return std::optional(std::exchange(text_, {}));
  }
}

int ChildProgram::wait() {
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace lode::io
