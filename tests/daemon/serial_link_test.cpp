// Serial links on real pseudo-terminals: the libserialport path (through tests/system/serial_shim.cpp, which
// this test is linked with). The raw path that pseudo-terminals take otherwise is tested in stream_test.

#include "daemon/wire/serial_link.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <filesystem>
#include <thread>

extern "C" int serial_shim_calls();
extern "C" tcflag_t serial_shim_flags();

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

using std::chrono::milliseconds;

/// The controller's end of a serial line.
struct Terminal {
  Terminal() : master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    ::grantpt(master);
    ::unlockpt(master);
    name = ::ptsname(master);
    keep = ::open(name.c_str(), O_RDWR | O_NOCTTY);  // so that closing the link is no hang-up
  }
  ~Terminal() { hang_up(); }
  void hang_up() {
    if (keep >= 0) ::close(keep);
    if (master >= 0) ::close(master);
    keep = master = -1;
  }
  std::string read() {
    char bytes[65536];
    pollfd events{master, POLLIN, 0};
    ::poll(&events, 1, 200);
    const ssize_t count = ::read(master, bytes, sizeof bytes);
    return {bytes, static_cast<std::size_t>(count > 0 ? count : 0)};
  }
  void write(const std::string& bytes) const {
    ASSERT_EQ(::write(master, bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  int master, keep = -1;
  std::string name;
};

TEST(SerialLink, TheLibserialportPathIsTaken) {
  const Terminal terminal;
  const int before = serial_shim_calls();
  const auto link = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(link) << link.error().message;
  EXPECT_GT(serial_shim_calls(), before + 2) << "libserialport was not asked";
}

TEST(SerialLink, EveryByteValuePassesBothWays) {
  Terminal terminal;
  const auto link = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(link) << link.error().message;
  std::string all;
  for (int i = 0; i < 256; ++i) all += static_cast<char>(i);
  std::string in;
  EXPECT_EQ((*link)->exchange(all, milliseconds(0), in).value(), all.size());
  EXPECT_EQ(terminal.read(), all) << "a terminal setting changes bytes";
  terminal.write(all);
  while (in.size() < all.size()) ASSERT_TRUE((*link)->exchange("", milliseconds(500), in));
  EXPECT_EQ(in, all);
}

TEST(SerialLink, SettingsAreRawAndBaudAsAsked) {
  const Terminal terminal;
  const auto link = open_serial_link(terminal.name, {57600});
  ASSERT_TRUE(link) << link.error().message;
  termios settings{};
  ASSERT_EQ(::tcgetattr(terminal.keep, &settings), 0);
  EXPECT_EQ(::cfgetospeed(&settings), static_cast<speed_t>(B57600));
  EXPECT_EQ(settings.c_lflag & (ICANON | ECHO | ISIG), 0u);
  EXPECT_EQ(settings.c_iflag & (IXON | IXOFF | ICRNL), 0u);
  EXPECT_EQ(settings.c_oflag & OPOST, 0u);
  int exclusive = 0;
  ASSERT_EQ(::ioctl(terminal.keep, TIOCGEXCL, &exclusive), 0);
  EXPECT_NE(exclusive, 0);
}

TEST(SerialLink, FramingAndHandshakeAsAsked) {
  struct Case {
    SerialFormat format;
    tcflag_t flags;  // of CSIZE, PARENB, PARODD, CSTOPB, CRTSCTS
  };
  for (const Case& c : {Case{{9600, 7, Parity::kEven, 2, false}, CS7 | PARENB | CSTOPB},
                        Case{{9600, 7, Parity::kEven, 1, false}, CS7 | PARENB},
                        Case{{4800, 7, Parity::kOdd, 1, true}, CS7 | PARENB | PARODD | CRTSCTS},
                        Case{{19200, 8, Parity::kNone, 1, true}, CS8 | CRTSCTS},
                        Case{{38400, 8, Parity::kNone, 1, false}, CS8}}) {
    const Terminal terminal;
    const auto link = open_serial_link(terminal.name, c.format);
    ASSERT_TRUE(link) << link.error().message;
    constexpr tcflag_t kFraming = CSIZE | PARENB | PARODD | CSTOPB | CRTSCTS;
    EXPECT_EQ(serial_shim_flags() & kFraming, c.flags) << c.format.baud;
    termios settings{};
    ASSERT_EQ(::tcgetattr(terminal.keep, &settings), 0);
    EXPECT_EQ(settings.c_iflag & (IXON | IXOFF), 0u) << "the driver would swallow DC1 and DC3";
  }
}

TEST(SerialLink, TheExclusiveFlagEndsWithTheLink) {
  const Terminal terminal;
  { ASSERT_TRUE(open_serial_link(terminal.name, {115200})); }
  int exclusive = 1;
  ASSERT_EQ(::ioctl(terminal.keep, TIOCGEXCL, &exclusive), 0);
  EXPECT_EQ(exclusive, 0);
  EXPECT_TRUE(open_serial_link(terminal.name, {115200})) << "cannot be opened again";
}

TEST(FieldFailures, F17_DtrResetsTheBoardAtOpen) {
  const Terminal terminal;
  for (const char* when : {"first", "again"}) {
    const auto link = open_serial_link(terminal.name, {115200});
    ASSERT_TRUE(link) << link.error().message;
    termios settings{};
    ASSERT_EQ(::tcgetattr(terminal.keep, &settings), 0);
    EXPECT_EQ(settings.c_cflag & HUPCL, 0u)
        << when << ": closing the port would drop DTR and reset the board";
  }
}

TEST(FieldFailures, F24_AnotherProgramTakesThePort) {
  const Terminal terminal;
  const auto first = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(first);
  const auto second = open_serial_link(terminal.name, {115200});
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, Code::kLink);
}

TEST(SerialLink, SymbolicLinksAreFollowed) {
  const Terminal terminal;
  const std::string path = "/tmp/tiltfeed_serial_" + std::to_string(::getpid());
  std::filesystem::create_symlink(terminal.name, path);
  const auto link = open_serial_link(path, {115200});
  std::filesystem::remove(path);
  EXPECT_TRUE(link) << link.error().message;
}

TEST(SerialLink, AFullWireTakesPartAndDoesNotBlock) {
  Terminal terminal;
  const auto link = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(link) << link.error().message;
  const std::string much(1000000, 'x');
  std::string in;
  std::size_t taken = 0;
  for (int i = 0; i < 3; ++i) taken += (*link)->exchange(much, milliseconds(100), in).value();
  EXPECT_GT(taken, 0u);
  EXPECT_LT(taken, much.size());
}

TEST(SerialLink, WaitingWaitsAndCostsNoProcessorTime) {
  const Terminal terminal;
  const auto link = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(link) << link.error().message;
  std::string in;
  const auto from = std::chrono::steady_clock::now();
  const std::clock_t cpu = std::clock();
  ASSERT_TRUE((*link)->exchange("", milliseconds(300), in));
  EXPECT_GE(std::chrono::steady_clock::now() - from, milliseconds(299));
  EXPECT_LT(std::clock() - cpu, CLOCKS_PER_SEC / 20);
}

TEST(SerialLink, AHangUpIsAnErrorAtOnceAndNotATimeout) {
  Terminal terminal;
  const auto link = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(link);
  terminal.hang_up();
  std::string in;
  const auto from = std::chrono::steady_clock::now();
  constexpr milliseconds kWait{600'000};
  const auto result = (*link)->exchange("", kWait, in);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, Code::kLink);
  EXPECT_LT(std::chrono::steady_clock::now() - from, kWait / 2);
}

TEST(SerialLink, Unplug_WhatTheWireTookCountsWhateverTheCallReturned) {
  Terminal terminal;
  const auto link = open_serial_link(terminal.name, {115200});
  ASSERT_TRUE(link);
  std::string got;
  // The device goes as soon as the bytes have come: the loss is seen by the call that wrote them.
  std::thread device([&] {
    pollfd events{terminal.master, POLLIN, 0};
    ::poll(&events, 1, -1);
    got = terminal.read();
    terminal.write("ok\r\n");
    terminal.hang_up();
  });
  std::string in;
  const auto taken = (*link)->exchange("G1X1\n", std::chrono::seconds(60), in);
  device.join();
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_EQ(*taken, got.size());
  EXPECT_EQ(got, "G1X1\n");
  // The loss is told, at the latest when what had come is read.
  Result<std::size_t> after = (*link)->exchange("", milliseconds(0), in);
  if (after) after = (*link)->exchange("", milliseconds(0), in);
  ASSERT_FALSE(after);
  EXPECT_NE(after.error().message.find("connection lost"), std::string::npos);
}

TEST(SerialLink, WhatIsNoPortIsRefusedWithARemedy) {
  for (const char* path : {"/dev/null", "/nonexistent/tty", "/tmp"}) {
    const auto link = open_serial_link(path, {115200});
    ASSERT_FALSE(link) << path;
    EXPECT_EQ(link.error().code, Code::kLink);
    EXPECT_NE(link.error().message.find("dialout"), std::string::npos);
  }
}

}  // namespace
}  // namespace tiltfeed
