// The Modbus link against a libmodbus server in a thread that is late, silent, refuses FC23 or drops its
// client, over TCP and over RTU on a pseudo-terminal. Behind it stands the scripted ring of fake_ring.h.

#include "daemon/wire/modbus_link.h"
#include "daemon/wire/open_link.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "daemon/stream/stream.h"
#include "tests/peers/fake_ring.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

/// What the server does to the reply of its n-th request.
enum class Trick { kNone, kLate, kSilent, kDropClient, kGarbage };

class Server {
 public:
  using Plan = std::function<Trick(int)>;

  explicit Server(bool rtu, Plan plan, bool fc23 = true, int baud = 115200)
      : rtu_(rtu), plan_(std::move(plan)) {
    mapping_ = modbus_mapping_new(0, 0, 0x300, 0);
    if (rtu) {
      wire_ = ::posix_openpt(O_RDWR | O_NOCTTY);
      ::grantpt(wire_);
      ::unlockpt(wire_);
      const std::string device = ::ptsname(wire_);
      keep_ = ::open(device.c_str(), O_RDWR | O_NOCTTY);
      termios settings{};
      ::tcgetattr(keep_, &settings);
      ::cfmakeraw(&settings);
      ::tcsetattr(keep_, TCSANOW, &settings);
      context_ = modbus_new_rtu(device.c_str(), baud, 'E', 8, 1);
      modbus_set_slave(context_, 1);
      modbus_set_socket(context_, wire_);
      link = *parse_link("modbus-rtu:" + device + "@" + std::to_string(baud) + "/1");
    } else {
      for (port_ = 15020; listener_ < 0 && port_ < 15120; ++port_) {
        context_ = modbus_new_tcp("127.0.0.1", port_);
        listener_ = modbus_tcp_listen(context_, 1);
        if (listener_ < 0) modbus_free(context_);
      }
      link = *parse_link("modbus-tcp:127.0.0.1:" + std::to_string(port_ - 1) + "/1");
    }
    ring.fc23 = fc23;
    thread_ = std::thread([this] { serve(); });
  }
  ~Server() { stop(); }
  void stop() {
    if (!thread_.joinable()) return;
    running_ = false;
    thread_.join();
    modbus_close(context_);
    modbus_free(context_);
    modbus_mapping_free(mapping_);
    if (listener_ >= 0) ::close(listener_);
    if (keep_ >= 0) ::close(keep_);
  }

  LinkSpec link;
  FakeRing ring;
  int requests = 0, connections = 0;
  int ahead = 0;  ///< requests on a serial line that came before the reply to the one before was read

 private:
  void serve() {
    while (running_) {
      pollfd events{wire_ >= 0 ? wire_ : listener_, POLLIN, 0};
      if (::poll(&events, 1, 20) <= 0) continue;
      if (wire_ < 0) {
        wire_ = modbus_tcp_accept(context_, &listener_);
        ++connections;
        continue;
      }
      std::uint8_t frame[MODBUS_MAX_ADU_LENGTH];
      const int length = modbus_receive(context_, frame);
      if (length < 0 && !rtu_) drop();
      if (length <= 0) continue;
      answer(frame, length);
    }
  }
  void drop() {
    modbus_close(context_);
    wire_ = -1;
  }
  /// TCP: until the client has closed the connection. RTU, where nobody can see it give up: half-way through
  /// its silence at kLateBaud, 0.34 s from either end, so that it may be that late itself.
  void wait_until_late() const {
    char next = 0;
    if (rtu_)
      std::this_thread::sleep_for(std::chrono::milliseconds(1030));
    else
      while (running_ && ::recv(wire_, &next, 1, MSG_PEEK) > 0) std::this_thread::yield();
  }
  void answer(const std::uint8_t* frame, int length) {
    const std::uint8_t* pdu = frame + modbus_get_header_length(context_);
    const auto word = [&](int at) { return static_cast<std::uint16_t>(pdu[at] << 8 | pdu[at + 1]); };
    ModbusRequest request;
    int data = 0, count = 0;
    if (pdu[0] == 3 || pdu[0] == 23) request.read_address = word(1), request.read_count = word(3);
    if (pdu[0] == 16) request.write_address = word(1), count = word(3), data = 6;
    if (pdu[0] == 23) request.write_address = word(5), count = word(7), data = 10;
    for (int i = 0; i < count; ++i) request.words.push_back(word(data + 2 * i));
    int unread = 0;
    if (rtu_ && ::ioctl(keep_, FIONREAD, &unread) == 0 && unread > 0) ++ahead;
    const Trick trick = plan_(requests++);
    const ModbusReply reply = ring.serve(request);
    ring.execute(7);
    if (trick == Trick::kDropClient) return drop();
    if (trick == Trick::kSilent) return;
    if (trick == Trick::kLate) wait_until_late();
    if (trick == Trick::kGarbage && ::write(wire_, "\x01\x03\x55\xAA", 4) == 4) return;
    if (reply.outcome != kReplyOk) {
      modbus_reply_exception(context_, frame, reply.outcome);
      return;
    }
    std::copy(reply.words.begin(), reply.words.end(), mapping_->tab_registers + request.read_address);
    if (modbus_reply(context_, frame, length, mapping_) < 0 && !rtu_) drop();
  }

  bool rtu_;
  Plan plan_;
  modbus_t* context_ = nullptr;
  modbus_mapping_t* mapping_ = nullptr;
  int listener_ = -1, wire_ = -1, keep_ = -1, port_ = 0;
  std::atomic<bool> running_{true};
  std::thread thread_;
};

constexpr int kBlocks = 140;
// Slow enough that the client waits for 0.69 s, and is then silent for as long.
constexpr int kLateBaud = 9600;

/// Sends kBlocks blocks; line k of the file is block k.
Result<SendReport> send_blocks(const LinkSpec& link) {
  const std::string path = "/tmp/tiltfeed_modbus_link_" + std::to_string(::getpid()) + ".nc";
  {
    std::ofstream out(path);
    out << "G0X0Y0Z0A0C0\n";
    for (int i = 2; i <= kBlocks; ++i) out << "G1X" << i << "F1000\n";
  }
  auto report = send_program(path, link, {}, {});
  std::filesystem::remove(path);
  return report;
}

void expect_each_block_once(Server& server, const Result<SendReport>& report, std::uint64_t resends) {
  server.stop();
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->executed, static_cast<std::uint64_t>(kBlocks));
  EXPECT_GE(report->resends, resends);  // more on a machine that is busy with other things
  ASSERT_EQ(server.ring.lines.size(), static_cast<std::size_t>(kBlocks));
  for (int i = 0; i < kBlocks; ++i) EXPECT_EQ(server.ring.lines[i], static_cast<std::uint32_t>(i + 1));
}

TEST(ModbusLink, ACleanWireNeedsNoResend) {
  for (const bool rtu : {false, true}) {
    Server server(rtu, [](int) { return Trick::kNone; });
    expect_each_block_once(server, send_blocks(server.link), 0);
    EXPECT_LT(server.requests, kBlocks / 7 + 20);
  }
}

TEST(ModbusLink, LateRepliesAreNeverTakenForTheNextOne) {
  for (const bool rtu : {false, true}) {
    Server server(
        rtu, [](int request) { return request == 6 || request == 12 ? Trick::kLate : Trick::kNone; }, true,
        kLateBaud);
    const auto report = send_blocks(server.link);
    expect_each_block_once(server, report, 2);
    EXPECT_EQ(server.ahead, 0) << "a late reply was taken for that of the next request";
    if (!rtu) {
      EXPECT_EQ(server.connections, 1 + static_cast<int>(report->resends))
          << "a late TCP reply must die with its connection";
    }
  }
}

TEST(ModbusLink, SilenceDropsAndGarbageAreRepeatedAway) {
  for (const bool rtu : {false, true}) {
    Server server(rtu, [&](int request) {
      if (request == 5 || request == 9) return Trick::kSilent;
      if (request == 13) return rtu ? Trick::kGarbage : Trick::kDropClient;
      return Trick::kNone;
    });
    expect_each_block_once(server, send_blocks(server.link), 3);
  }
}

TEST(ModbusLink, AControllerWithoutFc23GetsFc16AndFc3) {
  Server server(
      false, [](int) { return Trick::kNone; }, false);
  expect_each_block_once(server, send_blocks(server.link), 0);
}

TEST(ModbusLink, ARestartInTheMiddleIsAFault) {
  Server server(false, [&, frames = 0](int) mutable {
    if (++frames == 9) {
      server.ring.boot = 78;
      server.ring.session = 0;
      server.ring.state = 5;
    }
    return Trick::kNone;
  });
  const auto report = send_blocks(server.link);
  server.stop();
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("restarted"), std::string::npos) << report.error().message;
  EXPECT_LT(server.ring.lines.size(), static_cast<std::size_t>(kBlocks));
}

TEST(ModbusLink, AnEmptyRequestOnlyWaits) {
  Server server(false, [](int) { return Trick::kNone; });
  const auto link = open_modbus_link(server.link);
  ASSERT_TRUE(link) << link.error().message;
  std::string in;
  const auto from = std::chrono::steady_clock::now();
  EXPECT_EQ((*link)->exchange("", std::chrono::milliseconds(50), in).value(), 0u);
  EXPECT_GE(std::chrono::steady_clock::now() - from, std::chrono::milliseconds(50));
  EXPECT_TRUE(in.empty());
}

TEST(ModbusLink, ErrnosMeaning_IsThatOfTheOperationThatFailed) {
  const auto why = [](const std::string& text) {
    const auto link = open_link(*parse_link(text));
    EXPECT_FALSE(link) << text;
    return link ? "" : link.error().message;
  };
  // A listener whose queue is full answers nothing at all.
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  ::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size);
  const std::string place = "modbus-tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  EXPECT_NE(why(place).find("refused"), std::string::npos) << "nobody listens yet";
  ASSERT_EQ(::listen(listener, 0), 0);
  std::vector<int> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
    ::connect(clients.back(), reinterpret_cast<sockaddr*>(&address), sizeof address);
  }
  const std::string silent = why(place);
  EXPECT_NE(silent.find("no answer in 300 ms"), std::string::npos) << silent;
  EXPECT_EQ(silent.find("progress"), std::string::npos) << silent;
  for (const int client : clients) ::close(client);
  ::close(listener);
  const std::string unknown = why("modbus-tcp:" + std::string(70, 'n') + ".invalid:502");
  EXPECT_NE(unknown.find("check the name"), std::string::npos) << unknown;
}

}  // namespace
}  // namespace tiltfeed
