#include "desk/session/session_table.h"

#include <gtest/gtest.h>

#include <set>

#include "desk/session/secret.h"

namespace tiltfeed::desk {
namespace {

TEST(SessionTable, a_token_opens_one_session) {
  SessionTable table;
  const std::string token = *table.new_token();
  EXPECT_EQ(token.size(), 64u);
  EXPECT_FALSE(*table.open("")) << "before any other";
  EXPECT_FALSE(*table.open(token.substr(1)));
  const auto session = *table.open(token);
  ASSERT_TRUE(session);
  EXPECT_FALSE(*table.open(token)) << "a second time";
  EXPECT_FALSE(*table.open("")) << "when none is left";
  EXPECT_NE(session->cookie, session->csrf);
  ASSERT_TRUE(table.find(session->cookie));
  EXPECT_EQ(table.find(session->cookie)->csrf, session->csrf);
  EXPECT_FALSE(table.find(""));
  EXPECT_FALSE(table.find(session->csrf));
  table.close(session->cookie);
  EXPECT_FALSE(table.find(session->cookie));
}

TEST(SessionTable, only_the_newest_token_counts) {
  SessionTable table;
  const std::string first = *table.new_token(), second = *table.new_token();
  EXPECT_NE(first, second);
  EXPECT_FALSE(*table.open(first));
  EXPECT_TRUE(*table.open(second));
}

TEST(SessionTable, the_one_that_was_silent_for_longest_goes) {
  SessionTable table;
  std::vector<std::string> cookies;
  for (std::size_t i = 0; i < SessionTable::kSessions; ++i)
    cookies.push_back((*table.open(*table.new_token()))->cookie);
  EXPECT_TRUE(table.find(cookies[0]));  // heard: now the second is the oldest
  cookies.push_back((*table.open(*table.new_token()))->cookie);
  EXPECT_FALSE(table.find(cookies[1]));
  cookies.erase(cookies.begin() + 1);
  for (const std::string& cookie : cookies) EXPECT_TRUE(table.find(cookie));
  EXPECT_EQ(std::set<std::string>(cookies.begin(), cookies.end()).size(), SessionTable::kSessions);
}

TEST(SessionTable, compares_secrets) {
  EXPECT_TRUE(same_secret("", ""));
  EXPECT_TRUE(same_secret("abc", "abc"));
  for (const char* other : {"", "ab", "abcd", "abd", "bbc", "ABC"})
    EXPECT_FALSE(same_secret("abc", other)) << other;
}

}  // namespace
}  // namespace tiltfeed::desk
