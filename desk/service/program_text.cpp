#include "desk/service/program_text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace tiltfeed::desk {
namespace {

constexpr std::size_t kBlock = 64 * 1024;

ssize_t read_at(int fd, std::string& into, std::uint64_t at) {
  ssize_t count = -1;
  do count = ::pread(fd, into.data(), into.size(), static_cast<off_t>(at));
  while (count < 0 && errno == EINTR);
  return count;
}

}  // namespace

Result<ProgramText> ProgramText::open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return fail(Code::kIo, path + ": " + std::strerror(errno));
  ProgramText text(fd);
  struct stat about {};
  if (::fstat(fd, &about) != 0 || !S_ISREG(about.st_mode)) return fail(Code::kIo, path + ": is not a file");
  return text;
}

ProgramText::ProgramText(ProgramText&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      read_(other.read_),
      line_(other.line_),
      starts_(std::move(other.starts_)),
      whole_(other.whole_) {}

ProgramText& ProgramText::operator=(ProgramText&& other) noexcept {
  std::swap(fd_, other.fd_);
  read_ = other.read_, line_ = other.line_, whole_ = other.whole_;
  starts_ = std::move(other.starts_);
  return *this;
}

ProgramText::~ProgramText() {
  if (fd_ >= 0) ::close(fd_);
}

bool ProgramText::read_on() {
  std::string block(kBlock, '\0');
  for (std::size_t slice = 0; slice < kSlice && !whole_; slice += kBlock) {
    const ssize_t count = read_at(fd_, block, read_);
    if (count <= 0) return whole_ = true, false;
    const char* const end = block.data() + count;
    for (const char* at = block.data(); (at = static_cast<const char*>(std::memchr(
                                             at, '\n', static_cast<std::size_t>(end - at)))) != nullptr;) {
      ++at;
      if (++line_ % kStep == 0) starts_.push_back(read_ + static_cast<std::uint64_t>(at - block.data()));
    }
    read_ += static_cast<std::uint64_t>(count);
  }
  return !whole_;
}

std::vector<std::string> ProgramText::lines(std::uint64_t first, std::uint64_t count) const {
  std::vector<std::string> found;
  if (first == 0 || (first - 1) / kStep >= starts_.size()) return found;
  std::uint64_t at = starts_[static_cast<std::size_t>((first - 1) / kStep)];
  std::uint64_t skip = (first - 1) % kStep;
  std::string line, block(kBlock, '\0');
  for (std::size_t seen = 0; seen < kSlice && found.size() < count; seen += kBlock) {
    const ssize_t got = read_at(fd_, block, at);
    if (got <= 0) break;
    for (ssize_t i = 0; i < got && found.size() < count; ++i) {
      const char c = block[static_cast<std::size_t>(i)];
      if (c == '\n') {
        if (skip > 0)
          --skip;
        else
          found.push_back(line);
        line.clear();
      } else if (c != '\r' && skip == 0 && line.size() < kMaxLine) {
        line += c;
      }
    }
    at += static_cast<std::uint64_t>(got);
  }
  if (found.size() < count && skip == 0 && !line.empty())
    found.push_back(line);  // a last one without its end
  return found;
}

}  // namespace tiltfeed::desk
