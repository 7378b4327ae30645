// The signature of messages, against Python's hmac and hashlib.
#include "desk/webhooks/signature.h"

#include <gtest/gtest.h>

namespace tiltfeed::desk {
namespace {

// hmac.new(SECRET, f"{T}.{BODY}".encode(), hashlib.sha256).hexdigest()
TEST(Signature, is_the_one_of_python) {
  const std::string secret = "0f1e2d3c4b5a69788796a5b4c3d2e1f0", body = R"({"id":"5f","event":"done"})";
  EXPECT_EQ(signature_of(secret, 1764315878, body),
            "t=1764315878,v1=806c210d8ebf72613257aaa67477dea982d0b491561e06023562f749c5b155ea");
  EXPECT_EQ(signature_of(secret, 0, body),
            "t=0,v1=d7514f4381998336c2c34644a52dac512962396a5d1d0448163d2dbbac7a4d3f");
  EXPECT_EQ(signature_of(std::string(100, 'k'), 7, ""),
            "t=7,v1=f93ea0bb002c0ae8c35684589e84fd556aa107e5a5811225cfe42e73e6d007b2")
      << "a secret longer than a block";
  EXPECT_NE(signature_of(secret, 0, body + " "), signature_of(secret, 0, body));
}

// RFC 6234 and `printf abc | sha256sum`.
TEST(Signature, digests_are_those_of_the_standard) {
  EXPECT_EQ(sha256_digits("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256_digits(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

}  // namespace
}  // namespace tiltfeed::desk
