// Grbl over TCP, plain and through a WebSocket: the same guarantees as on a serial line, with the simulated
// machine as the peer.

#include "daemon/wire/tcp_link.h"
#include "daemon/wire/open_link.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include "daemon/machine/machine_place.h"
#include "daemon/stream/stream.h"
#include "tests/peers/tcp_machine.h"
#include "tests/shapes/wide_machine.h"
#include "tests/texts/folder.h"

namespace tiltfeed {
using namespace config;
using namespace daemon;
namespace {

class RealClock : public Clock {
 public:
  Time now() override { return std::chrono::steady_clock::now().time_since_epoch(); }
};

std::string feeds(int count) {
  std::string text = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nM3 S8000\nG1 F600000\n";
  for (int i = 1; i <= count; ++i) text += "G1 X" + std::to_string(i) + "\n";
  return text + "M5\nM2\n";
}

class NetworkLink : public testing::TestWithParam<const char*> {
 protected:
  bool web() const { return std::string(GetParam()) == "grbl-ws"; }
  LinkSpec link(const TcpMachine& machine) const {
    return *parse_link(std::string(GetParam()) + ":" + machine.place);
  }
};
INSTANTIATE_TEST_SUITE_P(Kinds, NetworkLink, testing::Values("grbl-tcp", "grbl-ws"),
                         [](const auto& kind) { return std::string(kind.index == 0 ? "Tcp" : "WebSocket"); });

TEST(TcpLink, IsReadAndWrittenAsText) {
  for (const char* text :
       {"grbl-tcp:192.168.0.5:23", "grbl-tcp:[fe80::1]:2300", "grbl-tcp:mill.local:8080"}) {
    const auto link = parse_link(text);
    ASSERT_TRUE(link) << link.error().message;
    EXPECT_EQ(link->kind, LinkKind::kGrbl);
    EXPECT_EQ(link->carrier, Carrier::kTcp);
    EXPECT_EQ(describe(*link), text);
  }
  for (const char* text : {"grbl-tcp:", "grbl-tcp:host", "grbl-tcp::23", "grbl-tcp:host:0",
                           "grbl-tcp:host:70000", "grbl-tcp:h:23/1"})
    EXPECT_EQ(parse_link(text).error().code, Code::kUsage) << text;
}

TEST(TcpLink, AWebSocketHasAPath) {
  for (const char* text :
       {"grbl-ws:192.168.0.5:80/ws", "grbl-ws:[fe80::1]:81", "grbl-ws:mill.local:8080/a/b?c=1"}) {
    const auto link = parse_link(text);
    ASSERT_TRUE(link) << link.error().message;
    EXPECT_EQ(link->kind, LinkKind::kGrbl);
    EXPECT_EQ(link->carrier, Carrier::kWebSocket);
    EXPECT_EQ(describe(*link), text);
  }
  EXPECT_EQ(parse_link("grbl-ws:h:81/")->path, "/");
  for (const char* text : {"grbl-ws:", "grbl-ws:host", "grbl-ws:host/ws", "grbl-ws::80", "grbl-ws:host:0/ws"})
    EXPECT_EQ(parse_link(text).error().code, Code::kUsage) << text;
}

TEST_P(NetworkLink, AProgramIsExecutedWholeAndInOrder) {
  const Folder folder("tcp_link");
  TcpMachine machine(wide_machine(), {}, "", 0.0, web());
  const auto report = send_program(folder.write("part.nc", feeds(700)), link(machine), {}, {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->executed, 706u);
  machine.end();
  EXPECT_EQ(machine.at_x, 700.0);
  EXPECT_EQ(machine.resets, 0u) << "connecting resets nothing";
}

/// As with a cable: what was executed lies between what is said to have run and what may have.
TEST_P(NetworkLink, ALostConnectionTellsTheRangeThatMayHaveRun) {
  for (const std::size_t cut : {5, 60, 300}) {
    const Folder folder("tcp_link");
    TcpMachine machine(wide_machine(), {}, "", 8.0, web());
    std::string text = "G0 X0 Y0 Z50 A0 C0\n";
    for (int i = 1; i <= 30000; ++i) text += "G1 X" + std::to_string(i % 2) + " F6000\n";
    SendState last;
    StreamHooks hooks;
    hooks.progress = [&](const SendState& state) {
      last = state;
      if (machine.executed > cut) machine.end();
      return true;
    };
    const auto report = send_program(folder.write("part.nc", text + "M2\n"), link(machine), {}, hooks);
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().code, Code::kLink);
    EXPECT_NE(report.error().message.find("connection lost"), std::string::npos) << report.error().message;
    EXPECT_NE(report.error().message.find("may have run"), std::string::npos) << report.error().message;
    EXPECT_LE(last.executed, machine.executed) << cut;
    EXPECT_GE(last.sent, machine.executed) << cut;
    EXPECT_LE(last.sent - last.executed, 1024u) << "a window of lines, not the program";
  }
}

TEST(TcpLink, WhatCannotBeReachedIsSaidWithTheReason) {
  // A port that nobody listens on: bound, and never listened to.
  const int fd = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(fd, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const auto refused =
      open_link(*parse_link("grbl-tcp:127.0.0.1:" + std::to_string(ntohs(address.sin_port))));
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("Connection refused"), std::string::npos) << refused.error().message;
  ::close(fd);
  const auto unknown = open_link(*parse_link("grbl-tcp:no.such.host.invalid:23"));
  ASSERT_FALSE(unknown);
  EXPECT_NE(unknown.error().message.find("check the name"), std::string::npos) << unknown.error().message;
}

/// The welcome of a connection is no proof of a reset.
TEST_P(NetworkLink, AMachineThatRunsWithoutASenderIsReallyReset) {
  TcpMachine machine(wide_machine(), {}, "", 1.0, web());
  const LinkSpec link = this->link(machine);
  RealClock clock;
  {
    const auto wire = open_link(link);
    ASSERT_TRUE(wire) << wire.error().message;
    std::string out = "G21 G90 G94\nM3 S8000\nG1 X900 F60\n", in;
    while (in.find("ok\r\nok\r\nok\r\n") == in.npos) {
      const auto taken = (*wire)->exchange(out, std::chrono::milliseconds(50), in);
      ASSERT_TRUE(taken);
      out.erase(0, *taken);
    }
  }
  const auto wire = open_link(link);
  ASSERT_TRUE(wire) << wire.error().message;
  const auto reset = reset_machine(link, **wire, clock);
  ASSERT_TRUE(reset) << reset.error().message;
  machine.end();
  EXPECT_EQ(machine.resets, 1u);
  EXPECT_EQ(machine.spindle, 0.0);
  EXPECT_LT(machine.at_x, 100.0);
}

/// Somebody else's server, or none: said, not waited for.
TEST(WebSocketLink, WhatIsNoWebSocketIsSaid) {
  TcpMachine plain(wide_machine(), {});
  const auto wrong = open_link(*parse_link("grbl-ws:" + plain.place));
  ASSERT_FALSE(wrong);
  EXPECT_NE(wrong.error().message.find("check port and path"), std::string::npos) << wrong.error().message;
  TcpMachine web(wide_machine(), {}, "", 0.0, true);
  const auto first = open_link(*parse_link("grbl-ws:" + web.place));
  ASSERT_TRUE(first) << first.error().message;
}

}  // namespace
}  // namespace tiltfeed
