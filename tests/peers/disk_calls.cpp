// The C library's calls that change or read a disk, for this program and every library that it has loaded.
// One thread at a time, in one process at a time, makes calls beneath the watched folder.

#include "tests/peers/disk_calls.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace tiltfeed {

DiskCalls& disk_calls() {
  static DiskCalls* const shared = [] {
    void* const place = ::mmap(nullptr, sizeof(DiskCalls), PROT_READ | PROT_WRITE,
                               MAP_SHARED | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (place == MAP_FAILED) std::abort();
    // Zero pages are what its members begin with, and stay untouched.
    return static_cast<DiskCalls*>(place);
  }();
  return *shared;
}

namespace {

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

/// Empty where nobody watches.
std::string watched(const std::string& path) {
  const DiskCalls& calls = disk_calls();
  if (!calls.watching) return {};
  const std::string_view root = calls.root;
  const bool beneath = path.starts_with(root) && (path.size() == root.size() || path[root.size()] == '/');
  return beneath ? path : std::string();
}

std::string path_of(int fd) {
  if (!disk_calls().watching) return {};
  char path[PATH_MAX];
  char link[40];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  const ssize_t size = ::readlink(link, path, sizeof path);
  return size > 0 ? watched(std::string(path, static_cast<std::size_t>(size))) : "";
}

std::string path_at(int folder, const char* name) {
  if (!disk_calls().watching) return {};
  if (name[0] == '/' || folder == AT_FDCWD) return watched(name);
  const std::string base = path_of(folder);
  return base.empty() ? base : base + "/" + name;
}

std::uint64_t inode_of(const std::string& path) {
  struct stat status {};
  return ::fstatat(AT_FDCWD, path.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 ? status.st_ino : 0;
}

std::string folder_of(const std::string& path) { return path.substr(0, path.rfind('/')); }
std::string name_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }

void log(DiskEntry entry, std::string_view text) {
  DiskCalls& calls = disk_calls();
  entry.size = text.size();
  if (calls.used + sizeof entry + text.size() > kDiskLog) std::abort();
  std::memcpy(calls.log + calls.used, &entry, sizeof entry);
  std::copy(text.begin(), text.end(), calls.log + calls.used + sizeof entry);
  calls.used += sizeof entry + text.size();
}

/// Is it this call's turn to fail? errno is set then.
bool fails(const char* call, const std::string& path, bool changes) {
  DiskCalls& calls = disk_calls();
  if (!calls.failing || (calls.fault.error == ENOSPC && !changes)) return false;
  const int number = ++calls.calls;
  const DiskFault& fault = calls.fault;
  if (fault.call == 0 || number < fault.call || (number > fault.call && !fault.after)) return false;
  if (calls.failed[0] == '\0')
    std::snprintf(calls.failed, sizeof calls.failed, "%s %s", call, path.c_str() + std::strlen(calls.root));
  errno = fault.error;
  return true;
}

/// The half of a write that a full disk takes before it says so.
std::size_t taken_before(std::size_t count) {
  const DiskCalls& calls = disk_calls();
  return calls.fault.part && calls.calls == calls.fault.call ? count / 2 : 0;
}

/// Does the file find room for growing to `size`? errno is set where not.
bool grows(int fd, std::uint64_t size) {
  DiskCalls& calls = disk_calls();
  struct stat status {};
  if (!calls.full || ::fstat(fd, &status) != 0) return true;
  const auto now = static_cast<std::uint64_t>(status.st_size);
  if (size > now + calls.room) {
    errno = calls.full_error;
    return false;
  }
  calls.room += now - std::max(size, now);
  return true;
}

/// Room that a file or a part of it gives back.
void give_back(std::uint64_t bytes) {
  if (disk_calls().full) disk_calls().room += bytes;
}

template <class Write>
ssize_t write_to(const char* call, int fd, const void* bytes, std::size_t count, off_t at,
                 const Write& real) {
  const std::string path = path_of(fd);
  if (path.empty()) return real(bytes, count);
  if (fails(call, path, true)) {
    count = taken_before(count);
    if (count == 0) return -1;
  }
  if (!grows(fd, static_cast<std::uint64_t>(at) + count)) return -1;
  const ssize_t written = real(bytes, count);
  struct stat status {};
  // A power loss leaves nothing of a file without a name.
  if (written > 0 && ::fstat(fd, &status) == 0 && status.st_nlink > 0)
    log({DiskOp::kWrite, status.st_ino, 0, static_cast<std::uint64_t>(at), 0},
        {static_cast<const char*>(bytes), static_cast<std::size_t>(written)});
  return written;
}

template <class Open>
int open_file(const std::string& path, int flags, const Open& real) {
  if (path.empty()) return real();
  const bool makes = (flags & O_CREAT) != 0 && inode_of(path) == 0;
  if (fails("open", path, makes)) return -1;
  const int fd = real();
  if (fd < 0) return fd;
  if (makes)
    log({DiskOp::kMake, inode_of(path), inode_of(folder_of(path)), 0, 0}, name_of(path));
  else if ((flags & O_TRUNC) != 0)
    log({DiskOp::kCut, inode_of(path), 0, 0, 0}, {});
  return fd;
}

int sync_file(const char* call, int fd) {
  const auto real = next<int (*)(int)>(call);
  const std::string path = path_of(fd);
  // What the real disk keeps is of no interest while a test watches.
  if (path.empty()) return disk_calls().watching ? 0 : real(fd);
  struct stat status {};
  ::fstat(fd, &status);
  const bool fail = fails(call, path, true);
  log({fail ? DiskOp::kNoSync : DiskOp::kSync, status.st_ino, 0, 0, 0}, {});
  return fail ? -1 : 0;
}

template <class Remove>
int take_name(const char* call, const std::string& path, const Remove& real) {
  if (path.empty()) return real();
  if (fails(call, path, true)) return -1;
  const std::uint64_t inode = inode_of(path), folder = inode_of(folder_of(path));
  struct stat status {};
  const bool is_file =
      ::fstatat(AT_FDCWD, path.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(status.st_mode);
  const int result = real();
  if (result != 0) return result;
  log({DiskOp::kUnlink, inode, folder, 0, 0}, name_of(path));
  if (is_file) give_back(static_cast<std::uint64_t>(status.st_size));
  return result;
}

template <class Read>
ssize_t read_from(const char* call, int fd, const Read& real) {
  const std::string path = path_of(fd);
  return !path.empty() && fails(call, path, false) ? -1 : real();
}

template <class Look>
int look_at(const char* call, const std::string& path, const Look& real) {
  return !path.empty() && fails(call, path, false) ? -1 : real();
}

mode_t mode_of(int flags, va_list list) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
}

int cut_file(int fd, off_t size) {
  const auto real = next<int (*)(int, off_t)>("ftruncate");
  const std::string path = path_of(fd);
  if (path.empty()) return real(fd, size);
  if (fails("ftruncate", path, true) || !grows(fd, static_cast<std::uint64_t>(size))) return -1;
  struct stat status {};
  const bool seen = ::fstat(fd, &status) == 0;
  const int result = real(fd, size);
  if (result == 0 && seen && status.st_size > size)
    give_back(static_cast<std::uint64_t>(status.st_size - size));
  if (result == 0 && seen) log({DiskOp::kCut, status.st_ino, 0, static_cast<std::uint64_t>(size), 0}, {});
  return result;
}

}  // namespace
}  // namespace tiltfeed

using namespace tiltfeed;

extern "C" {

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return open_file(path_at(AT_FDCWD, path), flags,
                   [&] { return next<int (*)(const char*, int, ...)>("open")(path, flags, mode); });
}

int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return ::open(path, flags, mode);
}

int openat(int folder, const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return open_file(path_at(folder, path), flags, [&] {
    return next<int (*)(int, const char*, int, ...)>("openat")(folder, path, flags, mode);
  });
}

/// openat2 has no function of its own. Like libc's, this takes six arguments, whoever gave fewer: what it
/// then reads beyond them is passed on and means nothing.
__attribute__((no_sanitize("address"))) long syscall(long number, ...) noexcept {
  va_list list;
  va_start(list, number);
  long a[6];
  for (long& one : a) one = va_arg(list, long);
  va_end(list);
  const auto real = [&] {
    return next<long (*)(long, ...)>("syscall")(number, a[0], a[1], a[2], a[3], a[4], a[5]);
  };
  if (number != SYS_openat2) return real();
  const auto* const how = reinterpret_cast<const std::uint64_t*>(a[2]);  // open_how begins with the flags
  return open_file(path_at(static_cast<int>(a[0]), reinterpret_cast<const char*>(a[1])),
                   static_cast<int>(*how), [&] { return static_cast<int>(real()); });
}

ssize_t write(int fd, const void* bytes, size_t count) {
  const auto real = [&](const void* from, std::size_t size) {
    return next<ssize_t (*)(int, const void*, size_t)>("write")(fd, from, size);
  };
  const bool seen = disk_calls().watching && !path_of(fd).empty();
  return seen ? write_to("write", fd, bytes, count, ::lseek(fd, 0, SEEK_CUR), real) : real(bytes, count);
}

ssize_t pwrite(int fd, const void* bytes, size_t count, off_t at) {
  return write_to("pwrite", fd, bytes, count, at, [&](const void* from, std::size_t size) {
    return next<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite")(fd, from, size, at);
  });
}
ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t at) {
  return ::pwrite(fd, bytes, count, at);
}

ssize_t read(int fd, void* bytes, size_t count) {
  return read_from("read", fd,
                   [&] { return next<ssize_t (*)(int, void*, size_t)>("read")(fd, bytes, count); });
}
ssize_t pread(int fd, void* bytes, size_t count, off_t at) {
  return read_from("pread", fd, [&] {
    return next<ssize_t (*)(int, void*, size_t, off_t)>("pread")(fd, bytes, count, at);
  });
}
ssize_t pread64(int fd, void* bytes, size_t count, off64_t at) { return ::pread(fd, bytes, count, at); }

int stat64(const char* path, struct stat64* status) noexcept {
  return look_at("stat", path_at(AT_FDCWD, path), [&] { return ::fstatat64(AT_FDCWD, path, status, 0); });
}
int lstat64(const char* path, struct stat64* status) noexcept {
  return look_at("lstat", path_at(AT_FDCWD, path),
                 [&] { return ::fstatat64(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW); });
}
int fstat64(int fd, struct stat64* status) noexcept {
  return look_at("fstat", path_of(fd), [&] { return ::fstatat64(fd, "", status, AT_EMPTY_PATH); });
}

int ftruncate(int fd, off_t size) noexcept { return cut_file(fd, size); }
int ftruncate64(int fd, off64_t size) noexcept { return cut_file(fd, size); }
int fsync(int fd) { return sync_file("fsync", fd); }
int fdatasync(int fd) { return sync_file("fdatasync", fd); }

int close(int fd) {
  const std::string path = path_of(fd);
  struct stat status {};
  // It never had a name: as open() with O_TMPFILE makes it.
  if (path.find("/#") != std::string::npos && ::fstat(fd, &status) == 0 && status.st_nlink == 0)
    give_back(static_cast<std::uint64_t>(status.st_size));
  const int result = next<int (*)(int)>("close")(fd);
  return !path.empty() && fails("close", path, true) ? -1 : result;
}

int mkdir(const char* name, mode_t mode) noexcept {
  const auto real = [&] { return next<int (*)(const char*, mode_t)>("mkdir")(name, mode); };
  const std::string path = path_at(AT_FDCWD, name);
  if (path.empty()) return real();
  if (fails("mkdir", path, true)) return -1;
  const int result = real();
  if (result == 0) log({DiskOp::kFolder, inode_of(path), inode_of(folder_of(path)), 0, 0}, name_of(path));
  return result;
}

int rename(const char* from, const char* to) noexcept {
  const auto real = [&] { return next<int (*)(const char*, const char*)>("rename")(from, to); };
  const std::string path = path_at(AT_FDCWD, from), target = path_at(AT_FDCWD, to);
  if (path.empty() || target.empty()) return real();
  if (fails("rename", path, true)) return -1;
  const std::uint64_t inode = inode_of(path), folder = inode_of(folder_of(path));
  if (folder != inode_of(folder_of(target))) std::abort();  // nothing of ours does
  const int result = real();
  if (result == 0) log({DiskOp::kRename, inode, folder, 0, 0}, name_of(path) + "/" + name_of(target));
  return result;
}

int unlink(const char* name) noexcept {
  return take_name("unlink", path_at(AT_FDCWD, name),
                   [&] { return next<int (*)(const char*)>("unlink")(name); });
}
int unlinkat(int folder, const char* name, int flags) noexcept {
  return take_name("unlinkat", path_at(folder, name),
                   [&] { return next<int (*)(int, const char*, int)>("unlinkat")(folder, name, flags); });
}
int remove(const char* name) noexcept {
  return take_name("remove", path_at(AT_FDCWD, name),
                   [&] { return next<int (*)(const char*)>("remove")(name); });
}
int rmdir(const char* name) noexcept {
  return take_name("rmdir", path_at(AT_FDCWD, name),
                   [&] { return next<int (*)(const char*)>("rmdir")(name); });
}

}  // extern "C"
