#include "daemon/command/patient_writer.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

namespace tiltfeed::daemon {

namespace {
/// More than a run has phases; of more the oldest are left out.
constexpr std::size_t kMostLines = 64;
constexpr std::chrono::milliseconds kLastWait{500};
constexpr int kRoomPoll = 100;  // ms
}  // namespace

struct PatientWriter::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::deque<std::string> lines;  // the front one is being written
  bool over = false, given_up = false, failed = false;

  /// Outlives the writer where the descriptor takes nothing; then what is begun is the last.
  void work(int descriptor) {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [&] { return over || !lines.empty(); });
      if (lines.empty() || failed || given_up) return;
      const std::string text = lines.front();
      lock.unlock();
      const bool written = write_all(descriptor, text);
      lock.lock();
      failed = failed || !written;
      lines.pop_front();
      changed.notify_all();
    }
  }

  bool write_all(int descriptor, std::string_view text) {
    while (!text.empty()) {
      const ssize_t taken = ::write(descriptor, text.data(), text.size());
      if (taken < 0 && errno == EINTR) continue;
      if (taken < 0 && errno == EAGAIN && await_room(descriptor)) continue;
      if (taken <= 0) return false;
      text.remove_prefix(static_cast<std::size_t>(taken));
    }
    return true;
  }

  /// Of a descriptor that does not block. False when nobody waits for the text any more.
  bool await_room(int descriptor) {
    pollfd room{descriptor, POLLOUT, 0};
    static_cast<void>(::poll(&room, 1, kRoomPoll));
    const std::lock_guard lock(mutex);
    return !given_up;
  }
};

PatientWriter::PatientWriter(int descriptor) : shared_(std::make_shared<Shared>()) {
  // Signals are for the thread that feeds the machine.
  sigset_t all, before;
  sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  // Its own: the number may be another file's by the time that this one takes something.
  const int own = ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0);
  std::thread([shared = shared_, own] {
    shared->work(own);
    if (own >= 0) ::close(own);
  }).detach();
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

PatientWriter::~PatientWriter() {
  std::unique_lock lock(shared_->mutex);
  shared_->over = true;
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, kLastWait, [&] { return shared_->lines.empty() || shared_->failed; });
  shared_->given_up = true;
}

void PatientWriter::write(std::string text, bool newest) {
  const std::lock_guard lock(shared_->mutex);
  auto& lines = shared_->lines;
  if (newest && lines.size() > 1) lines.resize(1);
  if (lines.size() >= kMostLines) lines.erase(lines.begin() + 1);
  lines.push_back(std::move(text));
  shared_->changed.notify_all();
}

bool PatientWriter::failed() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->failed;
}

}  // namespace tiltfeed::daemon
