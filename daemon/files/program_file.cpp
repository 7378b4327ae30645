#include "daemon/files/program_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cassert>
#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace tiltfeed::daemon {

Result<ProgramFile> ProgramFile::open(const std::string& path) {
  ProgramFile file(path, ::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat status {};
  if (file.fd_ < 0 || ::fstat(file.fd_, &status) != 0)
    return fail(Code::kIo, path + ": cannot be opened: " + std::strerror(errno));
  if (!S_ISREG(status.st_mode))
    return fail(Code::kInput,
                path + ": is not a regular file; a program is read twice, so save it to a file");
  return file;
}

ProgramFile::ProgramFile(ProgramFile&& other) noexcept
    : path_(std::move(other.path_)),
      fd_(std::exchange(other.fd_, -1)),
      keeps_(other.keeps_),
      known_(other.known_),
      piece_(other.piece_),
      pieces_(std::move(other.pieces_)),
      sum_(std::move(other.sum_)) {}

ProgramFile& ProgramFile::operator=(ProgramFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(fd_, other.fd_);
  std::swap(keeps_, other.keeps_);
  std::swap(known_, other.known_);
  std::swap(piece_, other.piece_);
  std::swap(pieces_, other.pieces_);
  std::swap(sum_, other.sum_);
  return *this;
}

ProgramFile::~ProgramFile() {
  if (fd_ >= 0) ::close(fd_);
}

tl::unexpected<Error> ProgramFile::changed() const {
  return fail(Code::kIo,
              path_ + ": was changed since it was checked; nothing of the change was sent. Send it again");
}

void ProgramFile::keep() {
  assert(piece_ == 0);
  keeps_ = true;
  known_ = false;
  pieces_.clear();
  sum_ = {};
}

Result<std::size_t> ProgramFile::read(char* to) {
  std::size_t size = 0;
  while (size < kPiece) {
    const ssize_t count = ::read(fd_, to + size, kPiece - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(Code::kIo, path_ + ": cannot be read: " + std::strerror(errno));
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
  }
  if (!keeps_) return size;
  if (known_ && piece_ == pieces_.size() && size == 0) return 0;
  if (known_ && piece_ >= pieces_.size()) return changed();
  if (size > 0 || known_) {
    const std::array<std::uint8_t, 32> digest = sha256({to, size});
    if (known_ && digest != pieces_[piece_]) return changed();
    if (!known_) {
      pieces_.push_back(digest);
      sum_.add({to, size});
    }
    ++piece_;
  }
  if (size < kPiece) known_ = true;
  return size;
}

Result<std::array<std::uint8_t, 32>> ProgramFile::finish() {
  assert(keeps_);
  const auto piece = std::make_unique<char[]>(kPiece);
  while (!known_) {
    const Result<std::size_t> size = read(piece.get());
    if (!size) return tl::unexpected<Error>(size.error());
  }
  return sum_.finish();
}

Result<void> ProgramFile::rewind() {
  if (::lseek(fd_, 0, SEEK_SET) != 0)
    return fail(Code::kIo, path_ + ": cannot be read again: " + std::strerror(errno));
  piece_ = 0;
  return {};
}

}  // namespace tiltfeed::daemon
