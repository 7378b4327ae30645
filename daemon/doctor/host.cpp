#include "daemon/doctor/host.h"

#include <fcntl.h>
#include <grp.h>
#include <pwd.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/timex.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace tiltfeed::daemon {

namespace {

namespace fs = std::filesystem;
constexpr const char* kUnitUser = "tiltfeed";
constexpr mode_t kAccessBits = 7;
constexpr unsigned kOwnerShift = 6, kGroupShift = 3;
constexpr int kMostGroups = 256;

std::string number_of(dev_t device) {
  return std::to_string(major(device)) + ":" + std::to_string(minor(device));
}

std::string first_line(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

/// What is in a folder; nothing where it cannot be read.
std::vector<fs::path> entries(const std::string& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    all.push_back(it->path());
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace

bool Asker::may(const struct stat& file, int want) const {
  if (uid == 0) return true;
  const auto bits = static_cast<mode_t>(want) & kAccessBits;
  const bool own = file.st_uid == uid,
             ours = std::find(groups.begin(), groups.end(), file.st_gid) != groups.end();
  const unsigned shift = own ? kOwnerShift : ours ? kGroupShift : 0;
  return ((file.st_mode >> shift) & bits) == bits;
}

Asker service_user() {
  const passwd* user = ::geteuid() == 0 ? ::getpwnam(kUnitUser) : nullptr;
  if (user == nullptr) user = ::getpwuid(::geteuid());
  Asker asker;
  asker.uid = user != nullptr ? user->pw_uid : ::geteuid();
  asker.name = user != nullptr ? user->pw_name : std::to_string(asker.uid);
  gid_t groups[kMostGroups];
  int count = kMostGroups;
  if (user != nullptr && ::getgrouplist(user->pw_name, user->pw_gid, groups, &count) > 0)
    asker.groups.assign(groups, groups + count);
  // The unit adds this group to its user's.
  if (const group* serial = asker.name == kUnitUser ? ::getgrnam("dialout") : nullptr)
    asker.groups.push_back(serial->gr_gid);
  return asker;
}

HostClock host_clock() {
  timex asked{};
  const int state = ::adjtimex(&asked);
  return {state >= 0 && state != TIME_ERROR && (asked.status & STA_UNSYNC) == 0, ::time(nullptr)};
}

std::vector<HostProcess> processes(const Host& host) {
  std::vector<HostProcess> all;
  for (const fs::path& folder : entries(host.root + "/proc")) {
    const std::string number = folder.filename();
    if (number.find_first_not_of("0123456789") != number.npos || number.size() > 9) continue;
    std::error_code none;
    all.push_back({std::stoi(number), first_line(folder / "comm"), fs::read_symlink(folder / "exe", none)});
  }
  return all;
}

std::vector<HostProcess> users_of(const Host& host, dev_t device) {
  std::vector<HostProcess> found;
  for (HostProcess& process : processes(host))
    for (const fs::path& open : entries(host.root + "/proc/" + std::to_string(process.pid) + "/fd")) {
      struct stat file {};
      if (process.pid == ::getpid() || ::stat(open.c_str(), &file) != 0 || !S_ISCHR(file.st_mode) ||
          file.st_rdev != device)
        continue;
      found.push_back(std::move(process));
      break;
    }
  return found;
}

std::string driver_of(const Host& host, dev_t device) {
  std::ifstream in(host.root + "/proc/devices");
  std::string name;
  for (std::string line; std::getline(in, line) && !line.starts_with("Block");) {
    std::istringstream words(line);
    unsigned number = 0;
    std::string driver;
    // 4 is "/dev/vc/0", "tty" and "ttyS": the last name is that of the serial ports.
    if (words >> number >> driver && number == major(device)) name = driver;
  }
  return name;
}

std::optional<std::string> device_figure(const Host& host, dev_t device, const std::string& file) {
  std::string line = first_line(host.root + "/sys/dev/char/" + number_of(device) + "/" + file);
  return line.empty() ? std::nullopt : std::optional(std::move(line));
}

std::string udev_property(const Host& host, dev_t device, const std::string& name) {
  std::ifstream in(host.root + "/run/udev/data/c" + number_of(device));
  const std::string begin = "E:" + name + "=";
  for (std::string line; std::getline(in, line);)
    if (line.starts_with(begin)) return line.substr(begin.size());
  return "";
}

std::string output_of(const std::string& program, std::vector<std::string> words) {
  std::array<int, 2> ends{-1, -1};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return "";
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  words.insert(words.begin(), program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = -1;
  const int failed = ::posix_spawn(&child, program.c_str(), &actions, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  std::string text;
  char bytes[256];
  for (ssize_t count = 0; failed == 0 && (count = ::read(ends[0], bytes, sizeof bytes)) > 0;)
    text.append(bytes, static_cast<std::size_t>(count));
  ::close(ends[0]);
  if (failed == 0) ::waitpid(child, nullptr, 0);
  return text;
}

}  // namespace tiltfeed::daemon
