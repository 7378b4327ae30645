// A disk that fails: loaded with LD_PRELOAD, it lets the n-th call of one function on an unfinished output
// (NAME.part-XXXX) or on the folder it is in fail with an errno. DISK_SHIM is "FUNCTION:N:ERRNO:FILE"; every
// failure is noted in FILE, so that a test can tell whether there was an n-th call.

#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

struct Fault {
  std::string function, note;
  int number = 0, reason = 0;
};

const Fault& fault() {
  static const Fault one = [] {
    Fault f;
    const char* text = std::getenv("DISK_SHIM");
    char function[16] = {}, note[PATH_MAX] = {};
    if (text != nullptr &&
        std::sscanf(text, "%15[a-z]:%d:%d:%4095s", function, &f.number, &f.reason, note) == 4)
      f.function = function, f.note = note;
    return f;
  }();
  return one;
}

std::string name_of(int fd) {
  char path[PATH_MAX];
  const std::string link = "/proc/self/fd/" + std::to_string(fd);
  const ssize_t size = ::readlink(link.c_str(), path, sizeof path);
  return size > 0 ? std::string(path, static_cast<std::size_t>(size)) : "";
}

bool unfinished(const std::string& name) { return name.find(".part-") != name.npos; }

bool folder(int fd) {
  struct stat at {};
  return ::fstat(fd, &at) == 0 && S_ISDIR(at.st_mode);
}

/// The file that was synced last, by the one thread that syncs.
std::string& synced() {
  static std::string name;
  return name;
}

/// Is it this call's turn?
bool fails(const char* function, const std::string& name) {
  static std::atomic<int> calls{0};
  if (fault().function != function || ++calls != fault().number) return false;
  const int note =
      next<int (*)(const char*, int, ...)>("open")(fault().note.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0666);
  const std::string line = name + "\n";
  if (note < 0 || next<ssize_t (*)(int, const void*, size_t)>("write")(note, line.data(), line.size()) < 0)
    std::abort();
  next<int (*)(int)>("close")(note);
  errno = fault().reason;
  return true;
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* bytes, size_t count) {
  const std::string name = fault().function == "write" ? name_of(fd) : "";
  if (unfinished(name) && fails("write", name)) return -1;
  return next<ssize_t (*)(int, const void*, size_t)>("write")(fd, bytes, count);
}

ssize_t pwrite(int fd, const void* bytes, size_t count, off_t at) {
  const std::string name = fault().function == "pwrite" ? name_of(fd) : "";
  if (unfinished(name) && fails("pwrite", name)) return -1;
  return next<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite")(fd, bytes, count, at);
}

ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t at) { return pwrite(fd, bytes, count, at); }

int fsync(int fd) {
  const std::string name = name_of(fd);
  synced() = name;
  if (unfinished(name) && fails("fsync", name)) return -1;
  if (folder(fd) && fails("fsyncdir", name)) return -1;
  return next<int (*)(int)>("fsync")(fd);
}

int close(int fd) {
  const std::string name = fault().function == "close" ? name_of(fd) : "";
  const int closed = next<int (*)(int)>("close")(fd);
  // Another descriptor of the file may be closed before: what is lost there the sync tells.
  return unfinished(name) && name == synced() && fails("close", name) ? -1 : closed;
}

int rename(const char* from, const char* to) noexcept {
  if (unfinished(from) && fails("rename", from)) return -1;
  return next<int (*)(const char*, const char*)>("rename")(from, to);
}

}  // extern "C"
