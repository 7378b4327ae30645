#include "sim/report/verify_progress.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstdio>

namespace tiltfeed::sim {

VerifyProgress::VerifyProgress(const std::string& file) : terminal_(isatty(STDERR_FILENO) == 1) {
  if (!file.empty()) file_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
}

VerifyProgress::~VerifyProgress() {
  if (file_ >= 0) ::close(file_);
  if (terminal_) std::fprintf(stderr, "\r\033[K");
}

/// One write of one length, "  7 stage": who reads sees a whole line.
void VerifyProgress::show(const std::string& stage, double share) {
  constexpr int kLine = 32;
  const auto now = std::chrono::steady_clock::now();
  if (stage == stage_ && now - shown_ <= std::chrono::milliseconds(100)) return;
  if (terminal_) std::fprintf(stderr, "\r\033[K%s %3.0f %%", stage.c_str(), share * 100.0);
  if (file_ >= 0) {
    std::array<char, kLine + 1> line{};
    std::snprintf(line.data(), line.size(), "%3.0f %-*.*s", share * 100.0, kLine - 5, kLine - 5,
                  stage.c_str());
    line[kLine - 1] = '\n';
    if (::pwrite(file_, line.data(), kLine, 0) < 0) ::close(file_), file_ = -1;
  }
  stage_ = stage;
  shown_ = now;
}

}  // namespace tiltfeed::sim
