// Deliveries on disk: over a restart, in order, within bounds; a folder that cannot be used.
#include "desk/webhooks/delivery_store.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace tiltfeed::desk {
namespace {

struct Folder {
  std::string path;
  explicit Folder(const std::string& name)
      : path(testing::TempDir() + "delivery_store_" + name + std::to_string(::getpid())) {
    std::filesystem::remove_all(path);
  }
  Folder(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path); }
};

HookMessage message(const std::string& id) { return {id, false, "{\"id\":\"" + id + "\"}"}; }

KnownService known_to(std::uint64_t run) { return {"ac5", RunMark{run, 10}, std::nullopt}; }

TEST(DeliveryStore, keeps_messages_and_mark_over_a_restart) {
  const Folder folder("restart");
  {
    auto store = DeliveryStore::open(folder.path);
    ASSERT_TRUE(store) << store.error().message;
    EXPECT_FALSE(store->known("/run/a")->mark);
    ASSERT_TRUE(
        store->keep("/run/a", known_to(5), {{"http://a/", message("x")}, {"http://b/", message("x")}}, 100));
    KnownService lost = known_to(6);
    lost.lost_since = 77;
    ASSERT_TRUE(store->keep("/run/a", lost, {{"http://a/", message("y")}}, 110));
    const auto first = store->first("http://a/");
    ASSERT_TRUE(first && *first);
    ASSERT_TRUE(store->put_off((*first)->number, 3, 140));
  }
  auto store = DeliveryStore::open(folder.path);
  ASSERT_TRUE(store) << store.error().message;
  const auto known = store->known("/run/a");
  ASSERT_TRUE(known && known->mark);
  EXPECT_EQ(*known->mark, (RunMark{6, 10}));
  EXPECT_EQ(known->machine, "ac5");
  EXPECT_EQ(known->lost_since, 77);
  EXPECT_FALSE(store->known("/run/b")->mark) << "another machine";
  auto first = store->first("http://a/");
  ASSERT_TRUE(first && *first);
  EXPECT_EQ((*first)->id + (*first)->body, "x{\"id\":\"x\"}");
  EXPECT_EQ((*first)->queued, 100);
  EXPECT_EQ((*first)->due, 140);
  EXPECT_EQ((*first)->tries, 3);
  ASSERT_TRUE(store->remove((*first)->number));
  EXPECT_EQ((*store->first("http://a/"))->id, "y") << "in order";
  EXPECT_EQ((*store->first("http://b/"))->id, "x");
  EXPECT_EQ(store->drop_others({"http://a/"}).value_or(9), 1u);
  EXPECT_FALSE(*store->first("http://b/"));
  EXPECT_EQ(store->waiting("http://a/").value_or(9), 1u);
}

TEST(DeliveryStore, the_same_message_waits_once) {
  const Folder folder("once");
  auto store = DeliveryStore::open(folder.path);
  ASSERT_TRUE(store);
  ASSERT_TRUE(store->keep("/s", known_to(1), {{"http://a/", message("x")}, {"http://a/", message("y")}}, 5));
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(store->keep("/s", known_to(1), {{"http://a/", message("x")}}, 100));
  EXPECT_EQ(store->waiting("http://a/").value_or(9), 2u);
  EXPECT_EQ((*store->first("http://a/"))->id, "x") << "it keeps its place";
  EXPECT_EQ((*store->first("http://a/"))->queued, 5) << "and its age";
}

TEST(DeliveryStore, drops_the_oldest_of_one_receiver) {
  const Folder folder("bounds");
  auto store = DeliveryStore::open(folder.path);
  ASSERT_TRUE(store);
  ASSERT_TRUE(store->keep("/s", known_to(1), {{"http://b/", message("b")}}, 0));
  std::vector<Addressed> many;
  for (std::size_t i = 0; i < DeliveryStore::kMostWaiting + 25; ++i)
    many.push_back({"http://a/", message(std::to_string(i))});
  EXPECT_EQ(store->keep("/s", known_to(2), many, 0).value_or(0), 25u);
  EXPECT_EQ(store->waiting("http://a/").value_or(0), DeliveryStore::kMostWaiting);
  EXPECT_EQ((*store->first("http://a/"))->id, "25");
  EXPECT_EQ(store->waiting("http://b/").value_or(0), 1u);
}

TEST(DeliveryStore, is_for_its_owner_and_for_one_desk) {
  const Folder folder("owner");
  auto store = DeliveryStore::open(folder.path);
  ASSERT_TRUE(store);
  struct stat about {};
  ASSERT_EQ(::stat(folder.path.c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777, 0700u);
  ASSERT_EQ(::stat((folder.path + "/webhooks.db").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777, 0600u);
  const auto second = DeliveryStore::open(folder.path);
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("another desk uses it"), std::string::npos) << second.error().message;
}

TEST(DeliveryStore, says_why_a_folder_cannot_be_used) {
  const auto nowhere = DeliveryStore::open(testing::TempDir() + "no/such/folder");
  ASSERT_FALSE(nowhere);
  EXPECT_NE(nowhere.error().message.find("`state`"), std::string::npos) << nowhere.error().message;
  const Folder folder("damaged");
  std::filesystem::create_directory(folder.path);
  std::ofstream(folder.path + "/webhooks.db") << std::string(5000, 'x');
  const auto damaged = DeliveryStore::open(folder.path);
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().message.find("move it away"), std::string::npos) << damaged.error().message;
}

}  // namespace
}  // namespace tiltfeed::desk
