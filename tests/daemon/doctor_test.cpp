// What `tiltfeed doctor` says of a made-up computer: /dev, /sys, /proc and udev's notes in a folder, the
// devices in it links to real pseudo-terminals.

#include "daemon/doctor/doctor.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/doctor/support_text.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

namespace fs = std::filesystem;
constexpr const char* kDevice = "/dev/ttyUSB0";

class Doctor : public testing::Test {
 protected:
  Doctor() {
    fs::remove_all(root);
    terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
    ::grantpt(terminal);
    ::unlockpt(terminal);
    const std::string name = ::ptsname(terminal);
    fs::create_directories(root / "dev/serial/by-id");
    fs::create_symlink(name, root / "dev/ttyUSB0");
    struct stat status {};
    ::stat(name.c_str(), &status);
    device = status.st_rdev;
    number = std::to_string(major(device)) + ":" + std::to_string(minor(device));
    owner = status.st_uid;
    put("proc/devices", "Character devices:\n  1 mem\n" + std::to_string(major(device)) +
                            " ttyUSB\n\nBlock devices:\n" + std::to_string(major(device)) + " sd\n");
    put("sys/dev/char/" + number + "/device/latency_timer", "1\n");
    host.root = root;
    host.programs = root / "bin";
    host.asker = {"tiltfeed", 4711, {status.st_gid}};
    host.clock = {true, 0};
    ::chmod(name.c_str(), 0660);
  }
  ~Doctor() override {
    ::close(terminal);
    fs::remove_all(root);
  }
  void put(const std::string& file, const std::string& text) const {
    fs::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text;
  }
  void put_process(int pid, const std::string& name, const std::string& program = "/usr/bin/x") const {
    put("proc/" + std::to_string(pid) + "/comm", name + "\n");
    fs::create_symlink(program, root / "proc" / std::to_string(pid) / "exe");
  }
  void put_program(const std::string& name, const std::string& version) const {
    put("bin/" + name, "#!/bin/sh\necho '" + name + " " + version + "'\n");
    fs::permissions(root / "bin" / name, fs::perms::owner_all);
  }
  /// The text of the finding, "good" where it is good.
  static std::string said(const Findings& findings, const std::string& what) {
    for (const Finding& one : findings)
      if (one.what == what)
        return one.verdict == Verdict::kGood ? "good" : verdict_name(one.verdict) + (": " + one.text);
    return "nothing";
  }
  std::string of_device(const std::string& what) const { return said(examine_device(host, kDevice), what); }

  const fs::path root = fs::path(testing::TempDir()) / ("doctor_test_" + std::to_string(::getpid()));
  int terminal = -1;
  dev_t device = 0;
  uid_t owner = 0;
  std::string number;
  Host host;
};

void expect_in(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), text.npos) << "in: " << text << "\nexpected: " << part;
}

TEST_F(Doctor, FindsNothingWrongWithAGoodDevice) {
  for (const Finding& one : examine_device(host, kDevice))
    EXPECT_EQ(one.verdict, Verdict::kGood) << one.what << ": " << one.text;
}

TEST_F(Doctor, NamesTheAdaptersWhereTheDeviceIsAbsent) {
  put("dev/serial/by-id/usb-FTDI_A50285BI-if00-port0", "");
  const std::string text = said(examine_device(host, "/dev/ttyUSB7"), "device");
  expect_in(text, "to do: /dev/ttyUSB7: No such file");
  expect_in(text, "usb-FTDI_A50285BI-if00-port0");
  put("dev/plain", "");
  expect_in(said(examine_device(host, "/dev/plain"), "device"), "is no device");
}

TEST_F(Doctor, JudgesTheServicesUserByOwnerGroupAndMode) {
  EXPECT_EQ(of_device("permission"), "good");
  host.asker.groups = {0xfffe};
  expect_in(of_device("permission"), "usermod -aG ");
  expect_in(of_device("permission"), "mode 0660");
  ::chmod((root / "dev/ttyUSB0").c_str(), 0666);
  EXPECT_EQ(of_device("permission"), "good");
  ::chmod((root / "dev/ttyUSB0").c_str(), 0606);  // who is in the group has the group's bits, not the others'
  struct stat status {};
  ::stat((root / "dev/ttyUSB0").c_str(), &status);
  host.asker.groups = {status.st_gid};
  expect_in(of_device("permission"), "60-tiltfeed.rules");
  ::chmod((root / "dev/ttyUSB0").c_str(), 0466);
  host.asker = {"owner", owner == 0 ? 1 : owner, {}};
  if (owner != 0) expect_in(of_device("permission"), "may not read and write it");
  host.asker.uid = 0;
  EXPECT_EQ(of_device("permission"), "good");
}

TEST_F(Doctor, SaysWhenTheUnitHidesTheDriver) {
  EXPECT_EQ(of_device("unit"), "good");
  put("proc/devices", "Character devices:\n" + std::to_string(major(device)) + " ttyAMA\n");
  expect_in(of_device("unit"), "DeviceAllow=char-ttyAMA rw");
  put("proc/devices", "Character devices:\n" + std::to_string(major(device)) + " tty\n" +
                          std::to_string(major(device)) + " ttyS\n");
  EXPECT_EQ(of_device("unit"), "good");
}

TEST_F(Doctor, NamesWhoHasTheDevice) {
  put_process(812, "screen");
  fs::create_directories(root / "proc/812/fd");
  EXPECT_EQ(of_device("in use"), "good");
  fs::create_symlink(fs::canonical(root / "dev/ttyUSB0"), root / "proc/812/fd/5");
  expect_in(of_device("in use"), "process 812 (screen) has it open");
  put("proc/812/comm", "tiltfeed\n");
  EXPECT_EQ(of_device("in use"), "good");
}

TEST_F(Doctor, SeesModemManagerAndBrlttyUnlessARuleKeepsThemOff) {
  EXPECT_EQ(of_device("ModemManager"), "good");
  put_process(77, "ModemManager");
  expect_in(of_device("ModemManager"), "sends modem commands");
  put("run/udev/data/c" + number, "S:serial\nE:ID_MM_DEVICE_IGNORE=0\n");
  expect_in(of_device("ModemManager"), "sends modem commands");
  put("run/udev/data/c" + number, "E:BRLTTY_BRAILLE_DRIVER=hm\nE:ID_MM_DEVICE_IGNORE=1\n");
  EXPECT_EQ(of_device("ModemManager"), "good");
  expect_in(of_device("brltty"), "braille display (hm)");
  put("run/udev/data/c" + number, "E:ID_MM_DEVICE_IGNORE=1\n");
  EXPECT_EQ(of_device("brltty"), "good");
}

TEST_F(Doctor, ReadsTheLatencyTimer) {
  put("sys/dev/char/" + number + "/device/latency_timer", "16\n");
  expect_in(of_device("latency timer"), "answers wait 16 ms");
  put("sys/dev/char/" + number + "/device/latency_timer", "?\n");
  expect_in(of_device("latency timer"), "to do");
  fs::remove_all(root / "sys");
  EXPECT_EQ(of_device("latency timer"), "good");
}

TEST_F(Doctor, WantsAllProgramsOfOneVersion) {
  const auto versions = [&] { return said(examine_host(host, "1.2 (commit a)"), "versions"); };
  expect_in(versions(), "bin/tiltfeed-sim does not start");
  put_program("tiltfeed-sim", "1.2 (commit a)");
  EXPECT_EQ(versions(), "good");
  put_program("tiltfeed-desk", "1.1 (commit b)");
  expect_in(versions(), "\"tiltfeed-desk 1.1 (commit b)\", and tiltfeed is 1.2 (commit a)");
}

TEST_F(Doctor, SeesAReplacedProcessAndAClockThatNobodyKeeps) {
  put_process(5, "tiltfeed", "/usr/bin/tiltfeed");
  EXPECT_EQ(said(examine_host(host, "1"), "running"), "good");
  EXPECT_EQ(said(examine_host(host, "1"), "clock"), "good");
  put_process(6, "tiltfeed", "/usr/bin/tiltfeed (deleted)");
  expect_in(said(examine_host(host, "1"), "running"), "process 6 runs a version that was replaced");
  host.clock.synchronised = false;
  expect_in(said(examine_host(host, "1"), "clock"), "not synchronised");
}

TEST_F(Doctor, JudgesTheFoldersOfAService) {
  ServiceConfig config;
  config.path = "/home/anna/ac5.yaml";
  config.spool = "/spool";
  config.socket = "/run/ac5/api.sock";
  const auto of = [&](const char* what) { return said(examine_places(host, config), what); };
  fs::create_directories(root / "spool");
  fs::create_directories(root / "run");
  ::chmod((root / "spool").c_str(), 0700);
  ::chmod((root / "run").c_str(), 0777);
  expect_in(of("spool"), "tiltfeed may not write there: chown");
  host.asker.uid = 0;
  EXPECT_EQ(of("spool"), "good");
  EXPECT_EQ(of("socket"), "good");  // the folder can be made
  EXPECT_NE(of("disk"), "nothing");
  expect_in(of("service"), "not asked: none answers at /run/ac5/api.sock");
  config.path = "/etc/tiltfeed/ac5.yaml";
  config.watch = "/srv/cam";
  expect_in(of("spool"), "below /var/lib/tiltfeed/ac5 only");
  expect_in(of("socket"), "below /run/tiltfeed/ac5 only");
  expect_in(of("watch"), "ReadWritePaths=/srv/cam");
  config.spool = "/var/lib/tiltfeed/ac5";
  host.asker.uid = 4711;  // /var may be root's: the unit makes the folder
  EXPECT_EQ(of("spool"), "good");
  config.spool = "/var/lib/tiltfeed/ac5b";
  expect_in(of("spool"), "below /var/lib/tiltfeed/ac5 only");
  put("spool/file", "");
  config.path = "x.yaml";
  config.spool = "/spool/file";
  expect_in(of("spool"), "is no folder");
}

TEST(SupportText, HasNoSecrets) {
  const std::pair<const char*, const char*> lines[] = {
      {"password: hunter2", "password: ***"},
      {"  API_TOKEN=abc def", "  API_TOKEN= ***"},
      {"{\"name\":1,\"Passphrase\" : \"x\"}", "{\"name\":1,\"Passphrase\" : ***"},
      {"client_secret: a token: b", "client_secret: ***"},
      {"link: grbl-ws:10.0.0.5:81", "link: grbl-ws:10.0.0.5:81"},
      {"see http://127.0.0.1:4711/#8f3a and go", "see http://127.0.0.1:4711/#*** and go"},
      {"https://bob:pw@shop.example/x?y#z", "https://***@shop.example/x?y#***"},
      {"ftp://a:b@c, then http://d/e#f", "ftp://***@c, then http://d/e#***"},
      {"mail to a@b://c/d@e", "mail to a@b://c/d@e"},
      {"passwords are kept elsewhere: there", "passwords are kept elsewhere: there"},
      {"# pwd=geheim, passwd: x", "# pwd= ***"},
      {"Authorization: Basic YTpi", "Authorization: ***"},
      {"sent Bearer eyJhbGci.x", "sent Bearer  ***"},
      {"tiltfeed desk --password hunter2", "tiltfeed desk --password  ***"},
      {"--api-token=x", "--api-token= ***"},
      {"a token is not named", "a token is not named"},
      {"secret_key: a", "secret_key: ***"},
      {"ssh --host-key=a", "ssh --host-key= ***"},
      {"# Cookie: a=b", "# Cookie: ***"},
      {"X-Tiltfeed-Csrf: 8f3a", "X-Tiltfeed-Csrf: ***"},
      {"pass: a", "pass: ***"},
      {"{user: a, 'pass': b}", "{user: a, 'pass': ***"},
      {"of this pass: 3 rows, a compass: north, bypass=1",
       "of this pass: 3 rows, a compass: north, bypass=1"},
      {"queue: postgresql://shop:a/b@db/shop", "queue: postgresql://***@db/shop"},
      {"postgres://shop:a?b#c@db/shop is away", "postgres://***@db/shop is away"},
      {"queue: \"postgresql://shop:a b@db/shop\"", "queue: \"postgresql://***@db/shop\""},
      {"postgresql://db:5432/shop, mail to a@b", "postgresql://db:5432/shop, mail to a@b"},
      {"postgresql://shop@db/shop?user=x@y", "postgresql://***@db/shop?user=x@y"},
      {"tls: \"-----BEGIN EC PRIVATE KEY-----\\nMIIB\\n-----END EC PRIVATE KEY-----\"", "tls: \"***"},
      {"-----BEGIN CERTIFICATE-----", "-----BEGIN CERTIFICATE-----"},
      {"", ""},
      {"cam:", "cam:"},
      {"  passwords:", "  passwords: ***"},
      {"    - hunter2", "    ***"},
      {"", ""},
      {"    - hunter3", "    ***"},
      {"  name: x", "  name: x"},
      {"token: |", "token: ***"},
      {"  abc", "  ***"},
      {"other: y", "other: y"},
  };
  std::string text, expected;
  for (const auto& [in, out] : lines) {
    if (std::string(out).find("    ***") == 0 || std::string(out) == "  ***") {
      EXPECT_EQ(without_secrets(in), in) << "without the line above";
    } else {
      EXPECT_EQ(without_secrets(in), out);
    }
    text += std::string(in) + "\n";
    expected += std::string(out) + "\n";
  }
  EXPECT_EQ(without_secrets(text), expected);
  EXPECT_EQ(
      without_secrets(
          "tls: |\n  -----BEGIN PRIVATE KEY-----\n  MIIB\n\n  Zz==\n  -----END PRIVATE KEY-----\nname: x\n"),
      "tls: |\n  ***\n  ***\n\n  ***\n  ***\nname: x\n");
  EXPECT_EQ(without_secrets("-----BEGIN RSA PRIVATE KEY-----\nMIIB"), "***\n***") << "cut off";
  EXPECT_EQ(support_section("a", "b\xff"), "==== a ====\n" + support_section("", "b\xff").substr(11));
}

TEST_F(Doctor, TheTailOfAFileBeginsWithALine) {
  put("log", "first\nsecond\nthird\n");
  EXPECT_EQ(tail_of_file(root / "log", 100), "first\nsecond\nthird\n");
  EXPECT_EQ(tail_of_file(root / "log", 18), "second\nthird\n");
  EXPECT_EQ(tail_of_file(root / "log", 13), "third\n");
  EXPECT_EQ(tail_of_file(root / "log", 3), "");
  EXPECT_EQ(tail_of_file(root / "none", 3), "cannot be read: No such file or directory");
}

}  // namespace
}  // namespace tiltfeed
