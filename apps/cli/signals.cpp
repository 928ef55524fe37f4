#include "signals.h"

#include <array>
#include <atomic>
#include <csignal>

namespace lode::cli {
namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP};

// A signal handler has no argument of its own: this is the one place where state must be global.
std::atomic<Progress*> cancel_target{nullptr};
std::atomic<int> received_signal{0};
static_assert(std::atomic<Progress*>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler may only touch lock-free atomics");

extern "C" void on_signal(int signal) {
  received_signal.store(signal);
  if (Progress* const progress = cancel_target.load()) progress->cancel();
}

}  // namespace

SignalGuard::SignalGuard(Progress& progress) {
  cancel_target.store(&progress);
  for (const int signal : kSignals) {
    struct sigaction current {};
    // nohup and background jobs hand signals over as ignored; they stay so.
    if (::sigaction(signal, nullptr, &current) != 0 || current.sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    ::sigaction(signal, &action, nullptr);
  }
}

SignalGuard::~SignalGuard() { cancel_target.store(nullptr); }

int SignalGuard::received() { return received_signal.load(); }

}  // namespace lode::cli
