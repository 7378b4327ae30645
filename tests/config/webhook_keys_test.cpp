// The keys of webhooks: where what is wrong stands, and that a secret stands in no message.
#include "config/webhook_keys.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config/desk_access.h"
#include "config/yaml_tree.h"

namespace tiltfeed::config {
namespace {

constexpr char kBegin[] = "listen: 127.0.0.1:0\nstate: state\nwebhooks:\n";

std::string error_of(const std::string& text) {
  const auto parsed = parse_desk_access(text, "desk.yaml");
  return parsed ? "" : parsed.error().message;
}

TEST(WebhookKeys, are_read) {
  const auto access =
      parse_desk_access(std::string(kBegin) +
                            "  - url: https://a.example:8443/in?x=1\n    secret_file: s/hook\n"
                            "  - {url: 'http://[::1]/', secret_file: /abs, events: fault}\n"
                            "  - {url: http://b, secret_file: s, events: [done]}\n",
                        "/etc/x/desk.yaml");
  ASSERT_TRUE(access) << access.error().message;
  EXPECT_EQ(access->state, "/etc/x/state");
  ASSERT_EQ(access->webhooks.size(), 3u);
  const Webhook &first = access->webhooks[0], &second = access->webhooks[1], &third = access->webhooks[2];
  EXPECT_EQ(first.url, "https://a.example:8443/in?x=1");
  EXPECT_EQ(first.host, "a.example:8443");
  EXPECT_EQ(first.secret_file, "/etc/x/s/hook");
  EXPECT_TRUE(first.done && first.fault) << "both, where nothing is said";
  EXPECT_EQ(second.host + second.secret_file, "[::1]/abs");
  EXPECT_TRUE(!second.done && second.fault);
  EXPECT_TRUE(third.done && !third.fault);
}

TEST(WebhookKeys, the_example_has_them) {
  const std::string path = std::string(SOURCE_DIR) + "/config/desk.yaml";
  const auto access = parse_desk_access(*read_config_text(path), path);
  ASSERT_TRUE(access) << access.error().message;
  EXPECT_FALSE(access->webhooks.empty());
}

TEST(WebhookKeys, what_is_wrong_is_named_with_its_place) {
  const std::string one = kBegin;
  const std::pair<std::string, const char*> cases[] = {
      {one + "  - url: ftp://a/\n    secret_file: s\n",
       "desk.yaml:4:10: webhooks[1].url: expected a URL that"},
      {one + "  - url: a.example\n    secret_file: s\n", "desk.yaml:4:10: webhooks[1].url"},
      {one + "  - url: http://\n    secret_file: s\n", "desk.yaml:4:10: webhooks[1].url"},
      {one + "  - url: http://a:0/\n    secret_file: s\n", "desk.yaml:4:10: webhooks[1].url"},
      {one + "  - url: http://a:65536/\n    secret_file: s\n", "desk.yaml:4:10: webhooks[1].url"},
      {one + "  - url: http://a:/\n    secret_file: s\n", "desk.yaml:4:10: webhooks[1].url"},
      {one + "  - url: http://a b/\n    secret_file: s\n",
       "desk.yaml:4:10: webhooks[1].url: a URL has no blanks"},
      {one + "  - url: 'http://a/#x'\n    secret_file: s\n",
       "desk.yaml:4:10: webhooks[1].url: a URL has no blanks"},
      {one + "  - url: http://u:p@a/\n    secret_file: s\n",
       "desk.yaml:4:10: webhooks[1].url: a name or password"},
      {one + "  - url: http://a/\n", "desk.yaml:4:5: missing key 'webhooks[1].secret_file'"},
      {one + "  - secret_file: s\n", "desk.yaml:4:5: missing key 'webhooks[1].url'"},
      {one + "  - {url: http://a/, secret_file: s, secret: x}\n",
       "desk.yaml:4:38: unknown key 'secret' in webhooks[1]"},
      {one + "  - {url: http://a/, secret_file: s, events: [done, failed]}\n",
       "desk.yaml:4:46: webhooks[1].events: expected [done, fault] or one of them, found 'failed'"},
      {one + "  - {url: http://a/, secret_file: s}\n  - {url: http://a/, secret_file: s}\n",
       "desk.yaml:5:11: webhooks[2].url: is there twice"},
      {one + "  url: http://a/\n", "desk.yaml:4:3: webhooks: expected a list of 1 to 8 maps"},
      {"listen: 127.0.0.1:0\nwebhooks:\n  - {url: http://a/, secret_file: s}\n",
       "desk.yaml:3:3: webhooks: state is needed, too"},
      {"listen: 127.0.0.1:0\nstate: s\n", "desk.yaml:2:8: state: not used without webhooks; remove it"}};
  for (const auto& [text, expected] : cases)
    EXPECT_EQ(error_of(text).rfind(expected, 0), 0u) << error_of(text);
}

struct SecretFile {
  std::string path = testing::TempDir() + "webhook_secret_" + std::to_string(::getpid());
  explicit SecretFile(const std::string& text, mode_t mode = 0600) {
    std::filesystem::remove(path);
    std::ofstream(path) << text;
    EXPECT_EQ(::chmod(path.c_str(), mode), 0);
  }
  SecretFile(const SecretFile&) = delete;
  ~SecretFile() { std::filesystem::remove(path); }
};

TEST(WebhookKeys, a_secret_is_one_line_for_its_owner_alone) {
  const std::string key = "0123456789abcdef";
  for (const std::string& text : {key, key + "\n", key + "\r\n"})
    EXPECT_EQ(read_secret_file(SecretFile(text).path).value_or(""), key);
  EXPECT_EQ(read_secret_file(SecretFile(key, 0400).path).value_or(""), key);
  EXPECT_TRUE(read_secret_file(SecretFile(std::string(1024, 'x') + "\n").path));
  for (const mode_t mode : {0640u, 0604u, 0660u, 0644u, 0610u}) {
    const SecretFile file(key, mode);
    const auto read = read_secret_file(file.path);
    ASSERT_FALSE(read) << mode;
    EXPECT_NE(read.error().message.find("chmod 600 " + file.path), std::string::npos) << read.error().message;
  }
  for (const std::string& wrong : {std::string(), std::string("0123456789abcde"), key + "\n" + key,
                                   key + " x", std::string("\n") + key, std::string(1025, 'x'), key + '\0'}) {
    const auto read = read_secret_file(SecretFile(wrong).path);
    ASSERT_FALSE(read) << wrong;
    EXPECT_NE(read.error().message.find("openssl rand"), std::string::npos) << read.error().message;
    EXPECT_EQ(read.error().message.find("01234"), std::string::npos) << "the secret stands in the message";
  }
  EXPECT_EQ(read_secret_file("/no/such/file").error().code, Code::kIo);
  EXPECT_FALSE(read_secret_file(testing::TempDir())) << "a folder";
  const std::string pipe = testing::TempDir() + "webhook_pipe_" + std::to_string(::getpid());
  std::filesystem::remove(pipe);
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(read_secret_file(pipe).error().message, pipe + ": is no regular file")
      << "nobody waits for a writer";
  std::filesystem::remove(pipe);
}

TEST(WebhookKeys, a_secret_that_others_may_read_is_told_at_its_key) {
  const SecretFile secret("0123456789abcdef", 0644);
  const std::string path = secret.path + ".yaml";
  std::ofstream(path) << kBegin << "  - url: http://a/\n    secret_file: " << secret.path << "\n";
  const auto access = load_desk_access(path);
  ASSERT_FALSE(access);
  EXPECT_EQ(access.error().message.rfind(path + ":5:18: webhooks[1].secret_file: ", 0), 0u)
      << access.error().message;
  ::chmod(secret.path.c_str(), 0600);
  const auto again = load_desk_access(path);
  ASSERT_TRUE(again) << again.error().message;
  EXPECT_EQ(again->webhooks[0].secret, "0123456789abcdef");
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace tiltfeed::config
