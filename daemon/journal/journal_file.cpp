// The journal's file operations on a real disk.

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "daemon/files/durable.h"
#include "daemon/journal/journal.h"

namespace tiltfeed::daemon {

namespace {

/// A descriptor and the folder that holds its name.
struct File {
  int fd = -1;
  std::string path;
  File() = default;
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() {
    if (fd >= 0) ::close(fd);
  }
};

constexpr mode_t kOwnerOnly = 0600;
constexpr const char* kInUse = ": the journal is in use by another run of this job";

std::ptrdiff_t write_all(int fd, std::uint64_t at, std::string_view bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count =
        ::pwrite(fd, bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return -errno;
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  return static_cast<std::ptrdiff_t>(done);
}

/// A new name survives a power loss only when its folder was made durable too.
int sync_name(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return sync_folder(folder.empty() ? "." : folder);
}

int open_locked(const std::string& path, int flags) {
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | flags, kOwnerOnly);
  if (fd < 0) return -errno;
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return fd;
  const int reason = errno;
  ::close(fd);
  return -reason;
}

Result<std::string> read_all(const File& file) {
  std::string bytes;
  char chunk[65536];
  if (::lseek(file.fd, 0, SEEK_SET) < 0) return fail(Code::kIo, file.path + ": " + std::strerror(errno));
  for (;;) {
    const ssize_t count = ::read(file.fd, chunk, sizeof chunk);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return fail(Code::kIo, file.path + ": " + std::strerror(errno));
    if (count == 0) return bytes;
    bytes.append(chunk, static_cast<std::size_t>(count));
  }
}

int replace_file(File& file, std::string_view content) {
  const std::string fresh = file.path + ".new";
  ::unlink(fresh.c_str());
  const int fd = open_locked(fresh, O_EXCL);
  if (fd < 0) return fd;
  const std::ptrdiff_t written = write_all(fd, 0, content);
  int result = written < 0 ? static_cast<int>(written) : 0;
  if (result == 0 && static_cast<std::size_t>(written) != content.size()) result = -ENOSPC;
  if (result == 0 && ::fsync(fd) != 0) result = -errno;
  if (result == 0 && ::rename(fresh.c_str(), file.path.c_str()) != 0) result = -errno;
  if (result < 0) {
    ::close(fd);
    ::unlink(fresh.c_str());
    return result;
  }
  ::close(file.fd);
  file.fd = fd;
  return sync_name(file.path);
}

}  // namespace

Result<JournalDisk> journal_file(const std::string& path) {
  const auto file = std::make_shared<File>();
  file->path = path;
  file->fd = open_locked(path, 0);
  if (file->fd < 0) {
    if (file->fd == -EWOULDBLOCK) return fail(Code::kIo, path + kInUse);
    return fail(Code::kIo, path + ": the journal cannot be opened: " + std::strerror(-file->fd));
  }
  JournalDisk disk;
  disk.name = path;
  disk.read = [file] { return read_all(*file); };
  disk.write = [file](std::uint64_t at, std::string_view bytes) { return write_all(file->fd, at, bytes); };
  disk.sync = [file] { return ::fdatasync(file->fd) == 0 ? 0 : -errno; };
  disk.replace = [file](std::string_view content) { return replace_file(*file, content); };
  return disk;
}

Result<JournalContent> read_journal_file(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return JournalContent{};
  File file;
  file.fd = fd;
  file.path = path;
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return fail(Code::kIo, path + kInUse);
  const Result<std::string> bytes = read_all(file);
  return bytes ? read_journal(*bytes) : JournalContent{};
}

}  // namespace tiltfeed::daemon
