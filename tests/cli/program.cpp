#include "tests/cli/program.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>

namespace lode::test {
namespace {

constexpr auto kPatience = std::chrono::seconds(60);

struct Pipe {
  std::array<int, 2> ends{-1, -1};
  Pipe() { EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0); }
};

/// Appends what is there; false at the end of the stream.
bool drain(int descriptor, std::string& text) {
  std::array<char, 4096> buffer{};
  const ssize_t n = ::read(descriptor, buffer.data(), buffer.size());
  if (n > 0) text.append(buffer.data(), static_cast<std::size_t>(n));
  return n > 0;
}

}  // namespace

nlohmann::json Finished::json() const {
  auto parsed = nlohmann::json::parse(out, nullptr, false);
  EXPECT_TRUE(parsed.is_object()) << "stdout: " << out << "\nstderr: " << err;
  return parsed;
}

Running::Running(const std::vector<std::string>& arguments) {
  std::vector<std::string> words{LODE_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const Pipe out;
  const Pipe err;
  process_ = ::fork();
  if (process_ == 0) {
    // Whatever the tests themselves ignore: a shell's jobs in the background, SIGINT.
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_DFL);
    ::dup2(out.ends[1], STDOUT_FILENO);
    ::dup2(err.ends[1], STDERR_FILENO);
    ::execv(argv[0], argv.data());
    ::_exit(127);
  }
  EXPECT_GT(process_, 0);
  ::close(out.ends[1]);
  ::close(err.ends[1]);
  out_ = out.ends[0];
  err_ = err.ends[0];
}

Running::~Running() {
  if (process_ > 0) {
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(out_);
  ::close(err_);
}

void Running::send(int signal) const { ::kill(process_, signal); }

std::uintmax_t Running::unnamed_bytes(const std::string& directory) const {
  std::uintmax_t largest = 0;
  std::error_code status;
  const std::string open_files = "/proc/" + std::to_string(process_) + "/fd";
  for (const auto& entry : std::filesystem::directory_iterator(open_files, status)) {
    const std::string target = std::filesystem::read_symlink(entry.path(), status).string();
    if (status || !target.starts_with(directory) || !target.ends_with("(deleted)")) continue;
    struct stat facts {};
    if (::stat(entry.path().c_str(), &facts) == 0)
      largest = std::max(largest, static_cast<std::uintmax_t>(facts.st_size));
  }
  return largest;
}

Finished Running::finish() {
  Finished run;
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  std::array<pollfd, 2> streams{pollfd{out_, POLLIN, 0}, pollfd{err_, POLLIN, 0}};
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    if (std::chrono::steady_clock::now() > deadline) {
      ADD_FAILURE() << "the program did not end in time";
      ::kill(process_, SIGKILL);
      break;
    }
    ::poll(streams.data(), streams.size(), 100);
    // A negative descriptor takes a stream that has ended out of the next poll.
    if (streams[0].revents != 0 && !drain(out_, run.out)) streams[0].fd = -1;
    if (streams[1].revents != 0 && !drain(err_, run.err)) streams[1].fd = -1;
  }
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return run;
}

Finished run_lode(const std::vector<std::string>& arguments) { return Running(arguments).finish(); }

Scratch::Scratch() {
  std::string name = (std::filesystem::temp_directory_path() / "lode-cli-XXXXXX").string();
  EXPECT_NE(::mkdtemp(name.data()), nullptr);
  directory_ = name;
}

Scratch::~Scratch() {
  std::error_code status;
  std::filesystem::remove_all(directory_, status);
}

std::vector<std::string> Scratch::files() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory_))
    names.push_back(entry.path().filename().string());
  std::ranges::sort(names);
  return names;
}

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_nrrd(const std::string& path, const Index3& dims,
                const std::function<int(int, int, int)>& value) {
  std::string bytes = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: " + std::to_string(dims[0]) +
                      ' ' + std::to_string(dims[1]) + ' ' + std::to_string(dims[2]) +
                      "\nspacings: 1 1 1\nencoding: raw\n\n";
  for (int z = 0; z < dims[2]; ++z)
    for (int y = 0; y < dims[1]; ++y)
      for (int x = 0; x < dims[0]; ++x) bytes += static_cast<char>(value(x, y, z));
  write_bytes(path, bytes);
}

void write_ball(const std::string& path) {
  write_nrrd(path, {{17, 17, 17}}, [](int x, int y, int z) {
    const double distance = std::sqrt((x - 8) * (x - 8) + (y - 8) * (y - 8) + (z - 8) * (z - 8));
    return std::max(0, static_cast<int>(200 - 20 * distance));
  });
}

void expect_refusal(const Finished& run, int exit_code, const std::vector<std::string>& words) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_TRUE(run.err.starts_with("lode: ")) << run.err;
  EXPECT_EQ(std::ranges::count(run.err, '\n'), 1) << run.err;
  for (const std::string& word : words)
    EXPECT_NE(run.err.find(word), std::string::npos) << "no '" << word << "' in: " << run.err;
}

}  // namespace lode::test
