// Makes the unmodified libserialport 0.1.1 take a pseudo-terminal, for tests of the code that uses it: it
// looks a port up in /sys/class/tty and asks for modem lines, and a pseudo-terminal has neither; nor has it
// seven bits or parity, so that these are kept here for a test to read and not passed on. Linked before the C
// library, or loaded with LD_PRELOAD; counts its calls, so that a test can prove that it was used.

#include <dlfcn.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <cstdarg>
#include <cstring>

namespace {

std::atomic<int> calls{0};
std::atomic<tcflag_t> asked_flags{0};
constexpr tcflag_t kKept = CSIZE | PARENB;

bool is_terminal_entry(const char* path) {
  constexpr char kFolder[] = "/sys/class/tty/pts/";
  return path != nullptr && std::strncmp(path, kFolder, sizeof kFolder - 1) == 0;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

void fill_link(struct stat* status) {
  ++calls;
  std::memset(status, 0, sizeof *status);
  status->st_mode = S_IFLNK | 0777;
}

}  // namespace

extern "C" {

int serial_shim_calls() { return calls; }
/// c_cflag of the newest tcsetattr.
tcflag_t serial_shim_flags() { return asked_flags; }

int tcsetattr(int fd, int when, const termios* settings) noexcept {
  asked_flags = settings->c_cflag;
  termios possible = *settings;
  if (isatty(fd) == 1) possible.c_cflag = (possible.c_cflag & ~kKept) | CS8;
  return next<int (*)(int, int, const termios*)>("tcsetattr")(fd, when, &possible);
}

int tcgetattr(int fd, termios* settings) noexcept {
  const int status = next<int (*)(int, termios*)>("tcgetattr")(fd, settings);
  if (status == 0 && asked_flags != 0)
    settings->c_cflag = (settings->c_cflag & ~kKept) | (asked_flags & kKept);
  return status;
}

int lstat(const char* path, struct stat* status) noexcept {
  if (!is_terminal_entry(path)) return next<int (*)(const char*, struct stat*)>("lstat")(path, status);
  fill_link(status);
  return 0;
}

int __lxstat(int version, const char* path, struct stat* status) noexcept {
  if (!is_terminal_entry(path))
    return next<int (*)(int, const char*, struct stat*)>("__lxstat")(version, path, status);
  fill_link(status);
  return 0;
}

ssize_t readlink(const char* path, char* buffer, size_t size) noexcept {
  if (!is_terminal_entry(path))
    return next<ssize_t (*)(const char*, char*, size_t)>("readlink")(path, buffer, size);
  ++calls;
  constexpr char kTarget[] = "../../devices/virtual/tty/pts";
  const size_t length = size < sizeof kTarget - 1 ? size : sizeof kTarget - 1;
  std::memcpy(buffer, kTarget, length);
  return static_cast<ssize_t>(length);
}

int ioctl(int fd, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (request == TIOCMGET || request == TIOCMSET || request == TIOCMBIS || request == TIOCMBIC) {
    ++calls;
    if (request == TIOCMGET) *static_cast<int*>(argument) = TIOCM_DTR | TIOCM_RTS;
    return 0;
  }
  return next<int (*)(int, unsigned long, ...)>("ioctl")(fd, request, argument);
}

}  // extern "C"
