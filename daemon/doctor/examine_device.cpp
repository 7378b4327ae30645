#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "daemon/doctor/doctor.h"

namespace tiltfeed::daemon {

namespace {

constexpr int kQuickMs = 1;  ///< latency timer of the rules that are installed

constexpr const char* kRule =
    ": add the adapter's idVendor to 60-tiltfeed.rules in /etc/udev/rules.d, udevadm control --reload, plug "
    "it "
    "in again";

std::string serial_ports(const Host& host) {
  std::string list;
  std::error_code error;
  const std::string folder = host.root + "/dev/serial/by-id";
  std::vector<std::string> names;
  for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    names.push_back(it->path().filename());
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list.empty() ? "no USB adapter is plugged in (nothing in /dev/serial/by-id)"
                      : "in /dev/serial/by-id there are: " + list;
}

std::string group_text(gid_t id) {
  const group* found = ::getgrgid(id);
  return found != nullptr ? found->gr_name : std::to_string(id);
}

Finding permission(const Host& host, const struct stat& file) {
  const bool self = host.asker.uid == ::geteuid();
  if (host.asker.may(file, R_OK | W_OK))
    return {Verdict::kGood, "permission",
            host.asker.name + (self ? " may" : ", who runs the service, may") + " read and write it"};
  char mode[8];
  std::snprintf(mode, sizeof mode, "%04o", file.st_mode & 07777U);
  const std::string group = group_text(file.st_gid);
  const bool for_group = (file.st_mode & (S_IRGRP | S_IWGRP)) == (S_IRGRP | S_IWGRP);
  return {Verdict::kToDo, "permission",
          host.asker.name + " may not read and write it: group " + group + ", mode " + mode + "; " +
              (for_group ? "usermod -aG " + group + " " + host.asker.name + ", then log in again"
                         : "install 60-tiltfeed.rules, which gives it to the group dialout")};
}

Finding unit(const Host& host, dev_t device) {
  const std::string driver = driver_of(host, device);
  for (const char* const known : {"ttyUSB", "ttyACM", "ttyS"})
    if (driver == known) return {Verdict::kGood, "unit", "lets " + driver + " devices through"};
  return {Verdict::kToDo, "unit",
          "tiltfeed@.service lets only ttyUSB, ttyACM and ttyS through: systemctl edit tiltfeed@NAME, in "
          "[Service] DeviceAllow=char-" +
              (driver.empty() ? "DRIVER" : driver) + " rw"};
}

Finding hands(const Host& host, dev_t device) {
  const std::vector<HostProcess> users = users_of(host, device);
  const auto other =
      std::find_if(users.begin(), users.end(), [](const HostProcess& one) { return one.name != "tiltfeed"; });
  if (other != users.end())
    return {Verdict::kToDo, "in use",
            "process " + std::to_string(other->pid) + " (" + other->name + ") has it open: end it"};
  return {Verdict::kGood, "in use",
          users.empty() ? "by nobody that can be seen from here"
                        : "by tiltfeed itself, process " + std::to_string(users[0].pid)};
}

/// It sends modem commands into every port that no rule keeps it off.
Finding modem_manager(const Host& host, dev_t device) {
  const std::vector<HostProcess> all = processes(host);
  const bool runs = std::any_of(all.begin(), all.end(),
                                [](const HostProcess& process) { return process.name == "ModemManager"; });
  if (!runs) return {Verdict::kGood, "ModemManager", "does not run"};
  if (udev_property(host, device, "ID_MM_DEVICE_IGNORE") == "1")
    return {Verdict::kGood, "ModemManager", "runs, and a udev rule keeps it off this device"};
  return {Verdict::kToDo, "ModemManager",
          std::string("runs and sends modem commands into it") + kRule +
              "; or systemctl mask --now ModemManager"};
}

/// udev starts it for adapters that it takes for braille displays, and the device goes.
Finding brltty(const Host& host, dev_t device) {
  const std::string display = udev_property(host, device, "BRLTTY_BRAILLE_DRIVER");
  if (display.empty()) return {Verdict::kGood, "brltty", "no udev rule gives it this device"};
  return {Verdict::kToDo, "brltty",
          "a udev rule takes it for a braille display (" + display + ")" + kRule + "; or apt remove brltty"};
}

Finding latency(const Host& host, const std::string& device, dev_t number) {
  const auto figure = device_figure(host, number, "device/latency_timer");
  if (!figure) return {Verdict::kGood, "latency timer", "its driver has none"};
  int ms = 0;
  const auto read = std::from_chars(figure->data(), figure->data() + figure->size(), ms);
  const std::string text = "answers wait " + *figure + " ms in the adapter";
  if (read.ec == std::errc() && ms <= kQuickMs) return {Verdict::kGood, "latency timer", text};
  const std::string name = std::filesystem::path(device).filename();
  return {Verdict::kToDo, "latency timer",
          text + ", which starves short blocks: echo 1 >/sys/bus/usb-serial/devices/" + name +
              "/latency_timer, or install 60-tiltfeed.rules"};
}

}  // namespace

Findings examine_device(const Host& host, const std::string& device) {
  struct stat file {};
  if (::stat((host.root + device).c_str(), &file) != 0)
    return {{Verdict::kToDo, "device",
             device + ": " + std::strerror(errno) + "; " + serial_ports(host) +
                 "; plug it in, or correct link in the service's file"}};
  if (!S_ISCHR(file.st_mode))
    return {{Verdict::kToDo, "device", device + " is no device; correct link in the service's file"}};
  std::error_code none;
  const std::string place = std::filesystem::canonical(host.root + device, none).string();
  Findings found = {{Verdict::kGood, "device", device + (place == device || none ? "" : " is " + place)}};
  found.push_back(permission(host, file));
  found.push_back(unit(host, file.st_rdev));
  found.push_back(hands(host, file.st_rdev));
  found.push_back(modem_manager(host, file.st_rdev));
  found.push_back(brltty(host, file.st_rdev));
  found.push_back(latency(host, place, file.st_rdev));
  return found;
}

}  // namespace tiltfeed::daemon
