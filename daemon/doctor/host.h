#pragma once
// This computer as the doctor sees it: who runs the service, processes, device numbers, the clock.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

struct stat;

namespace tiltfeed::daemon {

/// Who is to use files and devices.
struct Asker {
  std::string name;
  std::uint32_t uid = 0;
  std::vector<std::uint32_t> groups;

  /// By owner, group and mode, whoever asks now. `want`: of R_OK, W_OK and X_OK.
  bool may(const struct stat& file, int want) const;
};
/// The user of the units (tiltfeed) where this is asked by root and there is one; else who asks.
Asker service_user();

struct HostClock {
  bool synchronised = false;  ///< the kernel says that something keeps it
  std::int64_t now = 0;       ///< s since 1970
};
HostClock host_clock();

/// `root` stands before /dev, /sys, /proc, /run/udev and /etc: empty, or a made-up tree.
struct Host {
  std::string root;
  std::string programs;  ///< the folder of tiltfeed, tiltfeed-sim, tiltfeed-desk and tiltfeed-cad
  Asker asker;
  HostClock clock;
};

struct HostProcess {
  int pid = 0;
  std::string name, program;  ///< program: its file, " (deleted)" behind it when that was replaced
};
std::vector<HostProcess> processes(const Host& host);
/// Who has a file of this device number open, as far as /proc may be read.
std::vector<HostProcess> users_of(const Host& host, std::uint64_t device);
/// The driver's name of a character device's major number (/proc/devices), such as "ttyUSB"; may be empty.
std::string driver_of(const Host& host, std::uint64_t device);
/// The first line of /sys/dev/char/NUMBER/FILE; nothing where there is none.
std::optional<std::string> device_figure(const Host& host, std::uint64_t device, const std::string& file);
/// A property that udev's rules gave the device; may be empty.
std::string udev_property(const Host& host, std::uint64_t device, const std::string& name);

/// What the program prints when it is called with these words; empty where it does not start.
std::string output_of(const std::string& program, std::vector<std::string> words);

}  // namespace tiltfeed::daemon
