// Requests to receivers that are made up here: good ones, and all that a hostile one may do.
#include "desk/webhooks/http_posts.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <thread>

namespace tiltfeed::desk {
namespace {

/// Takes one connection after the other on loopback, answers each with the same bytes.
class Receiver {
 public:
  enum class Then { kClose, kStay, kForEver };
  Receiver(std::string answer, Then then) : answer_(std::move(answer)), then_(then) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(fd_, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(fd_, 8), 0);
    ::getsockname(fd_, reinterpret_cast<sockaddr*>(&address), &size);
    url = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/hook";
    thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
  }
  ~Receiver() {
    thread_.request_stop();
    ::shutdown(fd_, SHUT_RDWR);
    thread_.join();
    ::close(fd_);
  }
  std::string url, heard;

 private:
  void serve(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const int client = ::accept(fd_, nullptr, nullptr);
      if (client < 0) return;
      char bytes[4096];
      while (heard.find("}") == std::string::npos) {
        const ssize_t got = ::read(client, bytes, sizeof bytes);
        if (got <= 0) break;
        heard.append(bytes, static_cast<std::size_t>(got));
      }
      do
        if (::send(client, answer_.data(), answer_.size(), MSG_NOSIGNAL) < 0) break;
      while (then_ == Then::kForEver && !stop.stop_requested());
      if (then_ == Then::kStay) (void)!::read(client, bytes, 1);  // until the other end is gone
      ::close(client);
    }
  }
  int fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  std::string answer_;
  Then then_;
  std::jthread thread_;
};

PostAnswer post(const std::string& url, PostLimits limits = {}) {
  auto posts = HttpPosts::make(limits);
  EXPECT_TRUE(posts);
  EXPECT_TRUE(posts->start(3, url, {"Content-Type: application/json", "X-Tiltfeed-Signature: t=1,v1=2"},
                           "{\"a\":1}"));
  while (true) {
    const auto ended = posts->turn();
    if (!ended.empty()) {
      EXPECT_EQ(ended[0].lane, 3u);
      return ended[0].answer;
    }
    posts->wait(std::chrono::milliseconds(1000), {});
  }
}

TEST(HttpPosts, sends_body_and_headers_and_tells_the_answer) {
  Receiver receiver("HTTP/1.1 503 no\r\nRetry-After: 7\r\nContent-Length: 9\r\n\r\nbusy\n\x01\xff!!",
                    Receiver::Then::kClose);
  const PostAnswer answer = post(receiver.url);
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.retry_after, 7);
  EXPECT_EQ(answer.said, "busy   !!");
  EXPECT_EQ(receiver.heard.rfind("POST /hook HTTP/1.1\r\n", 0), 0u) << receiver.heard;
  for (const char* part : {"\r\nX-Tiltfeed-Signature: t=1,v1=2\r\n", "\r\nContent-Type: application/json\r\n",
                           "\r\n\r\n{\"a\":1}"})
    EXPECT_NE(receiver.heard.find(part), std::string::npos) << part << " in " << receiver.heard;
}

TEST(HttpPosts, an_answer_counts_as_soon_as_its_status_is_known) {
  const PostLimits limits{.whole = std::chrono::milliseconds(3000)};
  Receiver endless("HTTP/1.1 200 yes\r\n\r\n" + std::string(10'000, 'x'), Receiver::Then::kForEver);
  const PostLimits patient{.whole = std::chrono::hours(1)};
  EXPECT_EQ(post(endless.url, patient).status, 200) << "a body without an end is not read to its end";
  Receiver silent("HTTP/1.1 200 yes\r\nContent-Length: 50\r\n\r\nabc", Receiver::Then::kStay);
  EXPECT_EQ(post(silent.url, limits).status, 200);
  Receiver cut("HTTP/1.1 500 no\r\nContent-Length: 50\r\n\r\nabc", Receiver::Then::kClose);
  EXPECT_EQ(post(cut.url).status, 500);
}

TEST(HttpPosts, what_is_no_answer_is_none) {
  const PostLimits limits{.whole = std::chrono::milliseconds(500)};
  Receiver silent("", Receiver::Then::kStay);
  const PostAnswer never = post(silent.url, limits);
  EXPECT_EQ(never.status, 0);
  EXPECT_NE(never.why.find("no answer within"), std::string::npos) << never.why;
  for (const char* garbage :
       {"", "garbage\r\n\r\n", "HTTP/1.1 100 Continue\r\n\r\n", "220 smtp ready\r\n", "HTTP/1.1 2\r\n"}) {
    Receiver receiver(garbage, Receiver::Then::kClose);
    const PostAnswer answer = post(receiver.url, limits);
    EXPECT_EQ(answer.status, 0) << garbage;
    EXPECT_FALSE(answer.why.empty()) << garbage;
  }
  Receiver headers("X-More: " + std::string(1000, 'x') + "\r\n", Receiver::Then::kForEver);
  EXPECT_EQ(post(headers.url).status, 0) << "no status";
  const PostLimits patient{.whole = std::chrono::hours(1)};
  Receiver head("HTTP/1.1 503 no\r\nX-More: " + std::string(1000, 'x') + "\r\n", Receiver::Then::kForEver);
  EXPECT_EQ(post(head.url, patient).status, 503) << "a head without an end is not read to its end";
}

TEST(HttpPosts, follows_no_redirect) {
  Receiver target("HTTP/1.1 200 yes\r\nContent-Length: 0\r\n\r\n", Receiver::Then::kClose);
  Receiver receiver("HTTP/1.1 307 go\r\nLocation: " + target.url + "\r\nContent-Length: 0\r\n\r\n",
                    Receiver::Then::kClose);
  EXPECT_EQ(post(receiver.url).status, 307);
  EXPECT_TRUE(target.heard.empty());
}

TEST(HttpPosts, asks_by_http_and_https_alone) {
  EXPECT_EQ(post("file:///etc/passwd").status, 0);
  for (const char* scheme : {"gopher", "dict", "telnet", "ftp"}) {
    Receiver receiver("HTTP/1.1 200 yes\r\n\r\n", Receiver::Then::kClose);
    const std::string url = scheme + receiver.url.substr(receiver.url.find(':'));
    EXPECT_EQ(post(url).why, "Unsupported protocol") << url;
  }
  EXPECT_EQ(post("http://127.0.0.1:1/").status, 0) << "nobody listens there";
}

TEST(HttpPosts, requests_in_work_end_with_it) {
  Receiver silent("", Receiver::Then::kStay);
  auto posts = HttpPosts::make();
  ASSERT_TRUE(posts);
  ASSERT_TRUE(posts->start(0, silent.url, {}, "{}"));
  EXPECT_TRUE(posts->turn().empty());
}

TEST(HttpPosts, a_wait_ends_when_it_is_woken_or_a_descriptor_is_readable) {
  auto posts = HttpPosts::make();
  ASSERT_TRUE(posts);
  const std::jthread waker([&] { posts->wake(); });
  posts->wait(std::chrono::hours(1), {});
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::write(ends[1], "x", 1), 1);
  posts->wait(std::chrono::hours(1), {ends[0]});
  for (const int fd : ends) ::close(fd);
}

}  // namespace
}  // namespace tiltfeed::desk
