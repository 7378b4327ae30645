// Users and where the page is served: the file, the hash, the child that checks, the access file.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "config/desk_access.h"
#include "desk/users/password_check.h"
#include "desk/users/password_hash.h"
#include "desk/users/token_table.h"
#include "desk/users/user_table.h"

namespace tiltfeed::desk {
namespace {

TEST(Users, are_read_back_as_they_were_written) {
  const std::vector<User> users{{"ann", true, "$y$j9T$abc$def"}, {"bob.2-x_Y", false, "$y$j9T$./0$z"}};
  const auto read = parse_users("# people\n\n" + write_users(users), "u");
  ASSERT_TRUE(read);
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ(write_users(*read), write_users(users));
  const std::string file = testing::TempDir() + "users_" + std::to_string(::getpid());
  ASSERT_TRUE(save_users(file, users));
  EXPECT_EQ(write_users(*load_users(file)), write_users(users));
  struct stat about {};
  ASSERT_EQ(::stat(file.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0007, 0u) << "nobody else reads it";
  EXPECT_FALSE(load_users(file + ".none"));
  EXPECT_TRUE(parse_users("", "u")->empty());
}

TEST(Users, what_is_wrong_is_named_with_its_line) {
  const std::pair<const char*, const char*> cases[] = {
      {"ann\n", "u:1: expected NAME:ROLE:HASH"},
      {"\nann:admin:$y$x\n", "u:2: the role 'admin'"},
      {"a b:watch:$y$x\n", "u:1: the name"},
      {"ann:watch:plain\n", "u:1: the hash"},
      {"ann:watch:$6$x\n", "u:1: the hash"},
      {"ann:watch:$y$x\nann:operate:$y$x\n", "u:2: ann is there twice"},
      {"ann:watch:$y$x:y\n", "u:1: the hash"}};
  for (const auto& [text, message] : cases) {
    const auto read = parse_users(text, "u");
    ASSERT_FALSE(read) << text;
    EXPECT_EQ(read.error().message.rfind(message, 0), 0u) << read.error().message;
  }
}

TEST(Tokens, are_known_by_their_digest_alone) {
  // FIPS 180-4's own example.
  EXPECT_EQ(digest_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  const std::vector<ProgramToken> tokens{{"post", true, digest_of("one")}, {"wall", false, digest_of("two")}};
  const auto read = parse_tokens("# programs\n" + write_tokens(tokens), "t");
  ASSERT_TRUE(read);
  EXPECT_EQ(write_tokens(*read), write_tokens(tokens));
  EXPECT_EQ(find_token(*read, "one")->name, "post");
  EXPECT_TRUE(find_token(*read, "one")->submits);
  EXPECT_FALSE(find_token(*read, "two")->submits);
  for (const std::string& wrong : std::vector<std::string>{"", "on", "One", "one ", digest_of("one")})
    EXPECT_FALSE(find_token(*read, wrong)) << wrong;
  for (const auto& [text, message] : {std::pair{"post\n", "t:1: expected NAME:SCOPE:DIGEST"},
                                      std::pair{"\npost:operate:00\n", "t:2: the scope 'operate'"},
                                      std::pair{"post:submit:one\n", "t:1: the digest is none"}}) {
    const auto refused = parse_tokens(text, "t");
    ASSERT_FALSE(refused) << text;
    EXPECT_EQ(refused.error().message.rfind(message, 0), 0u) << refused.error().message;
  }
}

TEST(Users, a_file_that_everybody_may_write_lets_nobody_in) {
  const std::string path = "/tmp/tiltfeed_users_" + std::to_string(::getpid());
  ASSERT_TRUE(save_users(path, {{"ann", true, "$y$x"}}));
  EXPECT_TRUE(load_users(path));
  ASSERT_EQ(::chmod(path.c_str(), 0646), 0);
  const auto refused = load_users(path);
  std::filesystem::remove(path);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("chmod o-w " + path), std::string::npos) << refused.error().message;
}

TEST(Users, a_password_is_known_by_its_hash_alone) {
  const Result<std::string> hash = hash_password("a long secret"), other = hash_password("a long secret");
  ASSERT_TRUE(hash && other);
  EXPECT_EQ(hash->rfind("$y$", 0), 0u);
  EXPECT_NE(*hash, *other) << "each has a salt of its own";
  EXPECT_TRUE(password_matches("a long secret", *hash));
  for (const std::string wrong : {"a long secreT", "", "a long secret ", "a"})
    EXPECT_FALSE(password_matches(wrong, *hash));
  for (const std::string wrong : {"", "x", "$y$", "*0", "$y$j9T$", "plain"})
    EXPECT_FALSE(password_matches("plain", wrong)) << wrong;
  EXPECT_FALSE(password_matches(std::string("a long secret\0x", 15), *hash)) << "a byte 0 ends nothing";
  EXPECT_FALSE(hash_password("short"));
  EXPECT_FALSE(hash_password(std::string(257, 'x')));
}

TEST(Users, passwords_are_checked_in_turn_and_failures_counted) {
  const std::string hash = *hash_password("a long secret");
  PasswordCheck check;
  PasswordCheck::Time now{};
  std::string answers;
  const auto note = [&](bool good) { answers += good ? 'y' : 'n'; };
  const auto hear = [&] {
    pollfd ready{check.descriptor(), POLLIN, 0};
    ASSERT_EQ(::poll(&ready, 1, -1), 1);
    check.hear(now);
  };
  EXPECT_TRUE(check.ask("a long secret", hash, true, note, now));
  EXPECT_TRUE(check.ask("wrong", hash, true, note, now));
  EXPECT_TRUE(check.ask("a long secret", hash, false, note, now)) << "right, but of nobody";
  for (int i = 0; i < 3; ++i) hear();
  EXPECT_EQ(answers, "ynn");
  EXPECT_EQ(check.descriptor(), -1);
  for (std::size_t i = 2; i < PasswordCheck::kFailures; ++i) {
    ASSERT_TRUE(check.ask("wrong", hash, true, note, now));
    hear();
  }
  EXPECT_FALSE(check.ask("a long secret", hash, true, note, now)) << "too many failures";
  now += PasswordCheck::kPeriod;
  EXPECT_TRUE(check.ask("a long secret", hash, true, note, now));
  for (std::size_t i = 1; i < PasswordCheck::kWaiting; ++i)
    EXPECT_TRUE(check.ask("a long secret", hash, true, note, now));
  EXPECT_FALSE(check.ask("a long secret", hash, true, note, now)) << "too many wait";
  hear();
  EXPECT_EQ(answers.back(), 'y');
}

TEST(DeskAccess, another_address_needs_users_and_tls) {
  const auto parsed = [](const std::string& text) {
    return config::parse_desk_access(text, "/etc/x/desk.yaml");
  };
  EXPECT_TRUE(parsed("listen: 127.0.0.1:8370\n"));
  const auto whole = parsed("listen: 0.0.0.0:8370\nnames: [a.b:8370]\nusers: u\ncertificate: c\nkey: /k\n");
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->users + whole->certificate + whole->key, "/etc/x/u/etc/x/c/k");
  EXPECT_TRUE(whole->is_https());
  EXPECT_TRUE(parsed("listen: 10.0.0.1:80\nnames: a.b\nusers: u\nbehind_proxy: true\n"));
  for (const char* wrong :
       {"listen: 0.0.0.0:8370\n", "listen: 0.0.0.0:8370\nusers: u\n",
        "listen: 0.0.0.0:8370\nnames: a.b\ncertificate: c\nkey: k\n",
        "listen: 0.0.0.0:8370\nusers: u\ncertificate: c\nkey: k\n", "listen: 127.0.0.1:1\ncertificate: c\n",
        "listen: 127.0.0.1\n", "listen: localhost:80\n", "listen: 127.0.0.1:65536\n",
        "listen: 127.0.0.1:1x\n", "users: u\n", "listen: 127.0.0.1:1\nport: 5\n"})
    EXPECT_FALSE(parsed(wrong)) << wrong;
}

}  // namespace
}  // namespace tiltfeed::desk
