#include "config/output_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <set>
#include <streambuf>
#include <utility>

namespace tiltfeed::config {
namespace {

constexpr std::size_t kBuffer = 1 << 18;
constexpr mode_t kMode = 0666;  // less the process's umask
// Of a file's name so much goes into that of the file beside it: names are 255 bytes long at most.
constexpr std::size_t kMostName = 200;
constexpr const char* kStandardOutput = "-";
// Between the name and the digits of a file that is not finished.
constexpr const char* kMark = ".part-";
constexpr std::size_t kDigits = 16;
constexpr int kMostTries = 8;

/// The files of the process, for OutputFile::abandon().
struct Files {
  std::mutex mutex;
  std::set<std::string> unfinished;
  std::string committed;
};
Files& files() {
  static Files all;
  return all;
}

std::string folder_of(const std::string& path) {
  const auto slash = path.rfind('/');
  return slash == path.npos ? "." : slash == 0 ? "/" : path.substr(0, slash);
}

tl::unexpected<Error> io_failure(const std::string& path, const char* what, int reason) {
  return fail(Code::kIo,
              path + ": " + what + ": " + std::strerror(reason) + "; the file of that name is as it was");
}

/// 0 or errno.
int write_all(int fd, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t written = ::write(fd, bytes, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return written < 0 ? errno : ENOSPC;
    bytes += written, size -= static_cast<std::size_t>(written);
  }
  return 0;
}

/// A buffer before a descriptor, which keeps the first reason why it could not be written.
class DescriptorBuffer : public std::streambuf {
 public:
  explicit DescriptorBuffer(int fd) : fd_(fd), room_(kBuffer) {
    setp(room_.data(), room_.data() + room_.size());
  }
  int reason() const { return reason_; }

 protected:
  int sync() override {
    if (reason_ == 0) reason_ = write_all(fd_, pbase(), static_cast<std::size_t>(pptr() - pbase()));
    setp(room_.data(), room_.data() + room_.size());
    return reason_ == 0 ? 0 : -1;
  }
  int_type overflow(int_type c) override {
    if (sync() != 0) return traits_type::eof();
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    *pptr() = traits_type::to_char_type(c);
    pbump(1);
    return c;
  }
  std::streamsize xsputn(const char* bytes, std::streamsize count) override {
    if (count <= epptr() - pptr()) {
      std::memcpy(pptr(), bytes, static_cast<std::size_t>(count));
      pbump(static_cast<int>(count));
      return count;
    }
    if (sync() != 0) return 0;
    reason_ = write_all(fd_, bytes, static_cast<std::size_t>(count));
    return reason_ == 0 ? count : 0;
  }

 private:
  int fd_, reason_ = 0;
  std::vector<char> room_;
};

/// A name beside the file that nobody can foresee.
std::string name_beside(const std::string& path) {
  std::array<unsigned char, 8> random{};
  if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) return {};
  std::string name = path.substr(path.rfind('/') + 1).substr(0, kMostName) + kMark;
  for (const unsigned byte : random)
    name += "0123456789abcdef"[byte >> 4], name += "0123456789abcdef"[byte & 15];
  return path.rfind('/') == path.npos ? name : path.substr(0, path.rfind('/') + 1) + name;
}

/// A file that is being written is locked by its writer.
void remove_if_lost(const std::string& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return;
  struct stat at {};
  const bool lost = ::fstat(fd, &at) == 0 && S_ISREG(at.st_mode) && at.st_uid == ::geteuid() &&
                    ::flock(fd, LOCK_EX | LOCK_NB) == 0;
  if (lost) ::unlink(file.c_str());  // while it is locked: a writer that waits for it finds it gone
  ::close(fd);
}

/// Removes what writers of this file left that were killed.
void sweep_beside(const std::string& path) {
  const std::string start = path.substr(path.rfind('/') + 1).substr(0, kMostName) + kMark;
  const std::string folder = folder_of(path);
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.size() == start.size() + kDigits && name.starts_with(start) &&
        name.find_first_not_of("0123456789abcdef", start.size()) == name.npos)
      remove_if_lost(folder + "/" + name);
  }
}

/// A new file that is locked as long as its descriptor, or a copy of it, is open. Less than 0: errno.
int open_locked(const std::string& file) {
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, kMode);
  struct stat at {};
  // Where locks are not known nothing is ever swept.
  if (fd < 0 || ::flock(fd, LOCK_EX) != 0 || ::fstat(fd, &at) != 0 || at.st_nlink > 0) return fd;
  ::close(fd);  // taken for a lost one before it was locked
  errno = EAGAIN;
  return -1;
}

/// What is there is no file that may be replaced.
Result<void> check_target(const NamedFile& output) {
  const std::string& path = output.path;
  if (path == kStandardOutput) return {};
  const std::string name = (output.name.empty() ? "" : output.name + " ") + path;
  struct stat at {};
  if (::lstat(path.c_str(), &at) == 0 && !S_ISREG(at.st_mode)) {
    const char* what = S_ISLNK(at.st_mode) ? "is a symbolic link, which is not replaced; name the file itself"
                       : S_ISDIR(at.st_mode) ? "is a folder; name a file"
                                             : "is no regular file; name one, or - for the standard output";
    return fail(Code::kUsage, name + ": " + what);
  }
  const std::string folder = folder_of(path);
  if (path.empty() || path.back() == '/') return fail(Code::kUsage, name + ": a file's name is expected");
  if (::stat(folder.c_str(), &at) != 0 || ::access(folder.c_str(), W_OK | X_OK) != 0)
    return fail(Code::kIo, name + ": cannot be written: " + std::strerror(errno) + "; choose another folder");
  if (!S_ISDIR(at.st_mode)) return fail(Code::kIo, name + ": " + folder + " is no folder");
  return {};
}

/// The same file, or the same name in the same folder.
bool same(const std::string& a, const std::string& b) {
  if (a == kStandardOutput || b == kStandardOutput) return a == b;
  struct stat at_a {
  }, at_b{};
  if (::stat(a.c_str(), &at_a) == 0 && ::stat(b.c_str(), &at_b) == 0)
    return at_a.st_dev == at_b.st_dev && at_a.st_ino == at_b.st_ino;
  std::error_code error;
  const auto whole = [&](const std::string& name) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(name, error), error);
  };
  return whole(a) == whole(b);
}

}  // namespace

struct OutputFile::State {
  std::string path, temporary;  ///< temporary: empty where there is none, or no more
  int fd, lock;                 ///< lock: keeps the file locked after fd is closed
  DescriptorBuffer buffer;
  std::ostream out;

  State(std::string the_path, std::string beside, int descriptor)
      : path(std::move(the_path)),
        temporary(std::move(beside)),
        fd(descriptor),
        lock(::fcntl(descriptor, F_DUPFD_CLOEXEC, 0)),
        buffer(fd),
        out(&buffer) {}
  ~State() {
    if (!temporary.empty()) {
      const std::lock_guard all(files().mutex);
      ::unlink(temporary.c_str());
      files().unfinished.erase(temporary);
    }
    if (fd >= 0) ::close(fd);
    if (lock >= 0) ::close(lock);
  }
  Result<void> give_out();
  Result<void> settle();
  Result<void> take_name();
};

OutputFile::OutputFile(std::unique_ptr<State> state) : state_(std::move(state)) {}
OutputFile::OutputFile(OutputFile&& other) noexcept = default;
OutputFile::~OutputFile() = default;

Result<OutputFile> OutputFile::open(const std::string& path) {
  if (auto fits = check_target({"", path}); !fits) return tl::unexpected(fits.error());
  std::string beside;
  int fd = -1;
  if (path == kStandardOutput) {
    fd = ::memfd_create("tiltfeed", MFD_CLOEXEC);
  } else {
    sweep_beside(path);
    const std::lock_guard lock(files().mutex);
    for (int tries = 0; fd < 0 && tries < kMostTries; ++tries) {
      beside = name_beside(path);
      if (!beside.empty()) fd = open_locked(beside);
      if (fd < 0 && errno != EAGAIN) break;
    }
    if (fd >= 0) files().unfinished.insert(beside);
  }
  if (fd < 0)
    return fail(Code::kIo, path + ": cannot be written: " + std::strerror(errno) + "; choose another folder");
  return OutputFile(std::make_unique<State>(path, beside, fd));
}

std::ostream& OutputFile::stream() { return state_->out; }
int OutputFile::descriptor() const { return state_->fd; }

Result<void> OutputFile::flush() {
  State& s = *state_;
  s.out.flush();
  if (s.buffer.reason() != 0 || !s.out)
    return io_failure(s.path, "writing failed", s.buffer.reason() != 0 ? s.buffer.reason() : EIO);
  // So that the sync at the end has less to wait for. Where it is not known the sync does it all.
  if (!s.temporary.empty()) static_cast<void>(::sync_file_range(s.fd, 0, 0, SYNC_FILE_RANGE_WRITE));
  return {};
}

Result<void> OutputFile::overwrite(std::uint64_t at, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(state_->fd, bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return io_failure(state_->path, "writing failed", written < 0 ? errno : ENOSPC);
    at += static_cast<std::uint64_t>(written);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return {};
}

Result<void> OutputFile::State::give_out() {
  std::array<char, 1 << 16> bytes;
  for (off_t at = 0;;) {
    const ssize_t count = ::pread(fd, bytes.data(), bytes.size(), at);
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) return {};
    const int reason =
        count < 0 ? errno : write_all(STDOUT_FILENO, bytes.data(), static_cast<std::size_t>(count));
    if (reason != 0) return fail(Code::kIo, std::string("standard output: ") + std::strerror(reason));
    at += count;
  }
}

/// All of it is on the disk, under its name beside the file.
Result<void> OutputFile::State::settle() {
  if (temporary.empty()) return {};
  if (::fsync(fd) != 0) return io_failure(path, "cannot be made durable", errno);
  if (::close(std::exchange(fd, -1)) != 0) return io_failure(path, "writing failed", errno);
  return {};
}

Result<void> OutputFile::State::take_name() {
  if (temporary.empty()) return give_out();
  {
    const std::lock_guard all(files().mutex);
    struct stat at {};
    if (::lstat(path.c_str(), &at) == 0 && !S_ISREG(at.st_mode))
      return fail(Code::kIo, path + ": has become something else than a regular file; it is not replaced");
    if (::rename(temporary.c_str(), path.c_str()) != 0) return io_failure(path, "cannot be replaced", errno);
    files().unfinished.erase(temporary);
    files().committed += (files().committed.empty() ? "" : ", ") + path;
    temporary.clear();
  }
  const int folder = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) return {};  // a folder that may be written and not be read
  const int reason = ::fsync(folder) == 0 ? 0 : errno;
  ::close(folder);
  // Not every file system can sync a folder.
  if (reason != 0 && reason != EINVAL)
    return fail(Code::kIo,
                path + ": is written, but its folder cannot be made durable: " + std::strerror(reason));
  return {};
}

Result<void> OutputFile::commit() {
  if (auto flushed = flush(); !flushed) return flushed;
  if (auto settled = state_->settle(); !settled) return settled;
  return state_->take_name();
}

Result<void> OutputFile::commit_all(std::vector<OutputFile>& files) {
  for (OutputFile& file : files) {
    if (auto flushed = file.flush(); !flushed) return flushed;
    if (auto settled = file.state_->settle(); !settled) return settled;
  }
  for (OutputFile& file : files)
    if (auto taken = file.state_->take_name(); !taken) return taken;
  return {};
}

std::string OutputFile::abandon() {
  files().mutex.lock();  // for good
  for (const std::string& name : files().unfinished) ::unlink(name.c_str());
  return files().committed;
}

Result<void> check_outputs(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const NamedFile& output = outputs[i];
    if (output.path.empty()) continue;
    const auto clash = [&](const NamedFile& other, const char* what) {
      return fail(Code::kUsage, output.name + " " + output.path + ": is also " + what + " " + other.name +
                                    " " + other.path + "; name another file");
    };
    for (const NamedFile& input : inputs)
      if (!input.path.empty() && same(output.path, input.path)) return clash(input, "the input");
    for (std::size_t k = 0; k < i; ++k)
      if (!outputs[k].path.empty() && same(output.path, outputs[k].path))
        return clash(outputs[k], "the output");
    if (auto fits = check_target(output); !fits) return fits;
  }
  return {};
}

Result<void> write_file(const std::string& path, std::string_view bytes) {
  auto file = OutputFile::open(path);
  if (!file) return tl::unexpected(file.error());
  file->stream() << bytes;
  return file->commit();
}

}  // namespace tiltfeed::config
