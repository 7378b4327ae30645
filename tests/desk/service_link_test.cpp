// The client of the service's socket, against a service that is made up here.
#include "desk/service/service_link.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

namespace tiltfeed::desk {
namespace {

/// Listens, and answers by hand.
struct Service {
  std::string path = testing::TempDir() + "service_link_" + std::to_string(::getpid());
  int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  Service() {
    std::filesystem::remove(path);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0) << path;
    ::listen(fd, 64);
  }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;
  ~Service() {
    ::close(fd);
    ::unlink(path.c_str());
  }
  /// The next client, and what it said.
  int take(std::string& line) const {
    const int client = ::accept(fd, nullptr, nullptr);
    char bytes[4096];
    const ssize_t got = ::read(client, bytes, sizeof bytes);
    line.assign(bytes, got > 0 ? static_cast<std::size_t>(got) : 0);
    return client;
  }
};

void hear_all(ServiceLink& link) {
  for (const int fd : link.descriptors()) {
    pollfd ready{fd, POLLIN, 0};
    ::poll(&ready, 1, -1);
    EXPECT_TRUE(link.hear(fd));
  }
}

void say(int client, const std::string& text) {
  EXPECT_EQ(::write(client, text.data(), text.size()), static_cast<ssize_t>(text.size()));
}

TEST(ServiceLink, answers_in_any_order_and_in_pieces) {
  const Service service;
  ServiceLink link(service.path);
  std::string first, second, line;
  link.ask("{\"a\":1}",
           [&](const Result<std::string>& reply) { first = reply ? *reply : reply.error().message; });
  link.ask("{\"a\":2}", [&](const Result<std::string>& reply) {
    second = reply ? *reply : reply.error().message;
    link.ask("{\"a\":3}", [](const Result<std::string>&) {});  // asks again from inside
  });
  const int one = service.take(line);
  EXPECT_EQ(line, "{\"a\":1}\n");
  const int two = service.take(line);
  EXPECT_EQ(line, "{\"a\":2}\n");
  say(two, "{\"ok\":true,\"x\":2}\n");
  EXPECT_TRUE(link.hear(link.descriptors()[1]));
  EXPECT_EQ(second, "{\"ok\":true,\"x\":2}");
  EXPECT_EQ(first, "");
  say(one, "{\"ok\":fal");
  EXPECT_TRUE(link.hear(link.descriptors()[0]));
  EXPECT_EQ(first, "") << "it is not whole";
  say(one, "se,\"error\":\"not now\"}\n");
  EXPECT_TRUE(link.hear(link.descriptors()[0]));
  EXPECT_EQ(first, "not now");
  EXPECT_EQ(link.descriptors().size(), 1u);
  EXPECT_FALSE(link.hear(one)) << "of somebody else";
  ::close(one);
  ::close(two);
}

TEST(ServiceLink, tells_a_service_that_is_gone_from_one_that_refuses) {
  std::string line;
  ServiceLink nowhere(testing::TempDir() + "no_such_socket");
  std::optional<Code> code;
  const auto note = [&](const Result<std::string>& reply) {
    code = reply ? Code::kCancelled : reply.error().code;
  };
  nowhere.ask("{}", note);
  EXPECT_EQ(code, Code::kIo);
  const Service service;
  ServiceLink link(service.path);
  const std::pair<const char*, Code> replies[] = {{"{\"ok\":false,\"error\":\"no\"}\n", Code::kUsage},
                                                  {"{\"ok\":1}\n", Code::kUsage},
                                                  {"[]\n", Code::kIo},
                                                  {"\n", Code::kIo},
                                                  {"half", Code::kIo},
                                                  {"{\"ok\":true}\n", Code::kCancelled}};
  for (const auto& [reply, expected] : replies) {
    code.reset();
    link.ask("{}", note);
    const int client = service.take(line);
    say(client, reply);
    ::close(client);
    hear_all(link);
    EXPECT_EQ(code, expected) << reply;
  }
}

TEST(ServiceLink, takes_no_more_than_its_limit) {
  const Service service;
  ServiceLink link(service.path);
  std::size_t refused = 0;
  for (std::size_t i = 0; i < ServiceLink::kMost + 3; ++i)
    link.ask("{}", [&](const Result<std::string>& reply) {
      refused += !reply && reply.error().code == Code::kLimit;
    });
  EXPECT_EQ(refused, 3u);
  EXPECT_EQ(link.descriptors().size(), ServiceLink::kMost);
}

TEST(ServiceLink, hands_files_over) {
  const Service service;
  ServiceLink link(service.path);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  link.ask("{}", [](const Result<std::string>&) {}, {ends[1]});
  const int client = ::accept(service.fd, nullptr, nullptr);
  char byte;
  iovec into{&byte, 1};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))];
  msghdr message{};
  message.msg_iov = &into;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  ASSERT_EQ(::recvmsg(client, &message, 0), 1);
  const cmsghdr* const part = CMSG_FIRSTHDR(&message);
  ASSERT_TRUE(part && part->cmsg_type == SCM_RIGHTS);
  int handed = -1;
  std::memcpy(&handed, CMSG_DATA(part), sizeof handed);
  say(handed, "x");
  EXPECT_EQ(::read(ends[0], &byte, 1), 1);
  for (const int fd : {client, handed, ends[0], ends[1]}) ::close(fd);
}

}  // namespace
}  // namespace tiltfeed::desk
