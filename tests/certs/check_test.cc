#include <unistd.h>

#include <fstream>
#include <iterator>

#include "tests/certs/certs_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

// An authority with nodes a and b.
class Checking : public Certificates {
 protected:
  void SetUp() override {
    ASSERT_TRUE(make_authority(folder()));
    ASSERT_TRUE(make_node(folder(), "a"));
    ASSERT_TRUE(make_node(folder(), "b"));
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(file(name)) << text; }
  void copy(const std::string& from, const std::string& to) const {
    fs::copy_file(file(from), file(to), fs::copy_options::overwrite_existing);
  }
  std::string text_of(const std::string& name) const {
    std::ifstream in(file(name));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  // A certificate in d.pem and d.key that the authority has signed, made by openssl.
  void made_elsewhere(const std::string& key, const std::string& extensions) const {
    write("d.cnf", extensions);
    ASSERT_EQ(openssl("req -newkey " + key +
                      " -nodes -subj /CN=d -keyout d.key -out d.csr && openssl x509 -req -in d.csr"
                      " -CA ca.pem -CAkey ca.key -days 2 -extfile d.cnf -out d.pem")
                  .find("exit"),
              std::string::npos);
    fs::permissions(file("d.key"), fs::perms::owner_read | fs::perms::owner_write);
  }
};

TEST_F(Checking, ANodeOfTheAuthorityIsBelieved) {
  EXPECT_TRUE(check("a"));
  EXPECT_TRUE(check("b"));
}

TEST_F(Checking, AMissingFileIsNamed) {
  EXPECT_EQ(check("c").error().code, Errc::io);
  fs::remove(file("a.key"));
  expect_refused(check("a"), Errc::io, "/a.key: cannot open: ");
  fs::remove(file("a.pem"));
  expect_refused(check("a"), Errc::io, "/a.pem: cannot open: ");
  fs::remove(file("ca.pem"));
  expect_refused(check("a"), Errc::io, "/ca.pem: cannot open: ");
  fs::create_directory(file("ca.pem"));
  expect_refused(check("a"), Errc::io, "/ca.pem: ");
}

TEST_F(Checking, WhatIsNoCertificateOrKeyIsNamed) {
  const std::string certificate = text_of("a.pem"), key = text_of("a.key"), authority = text_of("ca.pem");
  for (const std::string& wrong : {std::string(), std::string("nothing\n"), key, certificate.substr(0, 200)}) {
    write("a.pem", wrong);
    expect_refused(check("a"), Errc::usage, "/a.pem: is not a certificate in PEM format");
  }
  write("a.pem", certificate + certificate.substr(0, 200));
  expect_refused(check("a"), Errc::usage, "/a.pem: is not a certificate in PEM format");
  write("a.pem", certificate);
  for (const std::string& wrong : {std::string(), certificate, key.substr(0, 60)}) {
    write("a.key", wrong);
    expect_refused(check("a"), Errc::usage, "/a.key: is not a key in PEM format");
  }
  write("a.key", key);
  write("ca.pem", "nothing");
  expect_refused(check("a"), Errc::usage, "/ca.pem: is not a certificate in PEM format");
  write("ca.pem", authority);
  EXPECT_TRUE(check("a"));
}

TEST_F(Checking, AKeyWithAPassphraseIsRefusedWithoutAskingForIt) {
  ASSERT_EQ(openssl("pkey -in a.key -aes128 -passout pass:secret -out secret.key").find("exit"), std::string::npos);
  write("a.key", text_of("secret.key"));
  ASSERT_PRED_FORMAT2(testing::IsSubstring, "ENCRYPTED", text_of("a.key"));
  expect_refused(check("a"), Errc::usage, "/a.key: is not a key in PEM format, or it has a passphrase");
}

TEST_F(Checking, ASwappedKeyIsNamed) {
  copy("b.key", "a.key");
  expect_refused(check("a"), Errc::usage, "/a.key: does not belong to " + file("a.pem").string());
}

TEST_F(Checking, ANodeOfAnotherAuthorityOfTheSameNameIsAStranger) {
  ASSERT_TRUE(make_authority(file("other")));
  copy("other/ca.pem", "ca.pem");
  expect_refused(check("a"), Errc::usage, "/a.pem: is not signed by " + file("ca.pem").string());
  ASSERT_EQ(openssl("req -x509 -key b.key -subj /CN=b -days 2 -addext keyUsage=digitalSignature -out b.pem"), "");
  expect_refused(check("b"), Errc::usage, "/b.pem: is not signed by ");
}

TEST_F(Checking, BothAuthoritiesAreTrustedWhileAClusterGoesOver) {
  ASSERT_TRUE(make_authority(file("new")));
  ASSERT_TRUE(make_node(file("new"), "c"));
  write("ca.pem", text_of("ca.pem") + text_of("new/ca.pem"));
  EXPECT_TRUE(check("a"));
  EXPECT_TRUE(check_node(file("ca.pem"), file("new/c.pem"), file("new/c.key")));
  ASSERT_TRUE(make_node(folder(), "d"));  // by the one whose key is here
  EXPECT_TRUE(check("d"));
}

TEST_F(Checking, DatesAreNamed) {
  ASSERT_TRUE(make_authority(file("old"), made(-3000 * day)));
  const auto past = made(-731 * day), future = made(2 * day);
  ASSERT_TRUE(make_node(file("old"), "a", past));
  expect_refused(check_node(node_certificate_in(file("old")).value()), Errc::usage,
                 "/a.pem: expired on " + date_text(past.now + 730 * day));
  ASSERT_TRUE(make_node(folder(), "early", future));
  expect_refused(check("early"), Errc::usage,
                 "/early.pem: is not valid before " + date_text(future.now - std::chrono::hours(1)));
  // An hour ahead of the others is no difference.
  auto ahead = made(0 * day);
  ahead.now += std::chrono::minutes(59);
  ASSERT_TRUE(make_node(folder(), "ahead", ahead));
  EXPECT_TRUE(check("ahead"));
}

TEST_F(Checking, AnAuthorityThatHasExpiredIsNamed) {
  // By openssl, which lets a node outlive it.
  const auto long_ago = made(-3651 * day);
  ASSERT_TRUE(make_authority(file("old"), long_ago));
  copy("old/ca.pem", "ca.pem");
  copy("old/ca.key", "ca.key");
  made_elsewhere("rsa:2048", "extendedKeyUsage=serverAuth,clientAuth\n");
  expect_refused(check("d"), Errc::usage, "/ca.pem: expired on " + date_text(long_ago.now + 3650 * day));
}

TEST_F(Checking, AKeyThatOthersCanReadIsRefused) {
  for (const int wrong : {0640, 0604, 0620, 0666}) {
    fs::permissions(file("a.key"), static_cast<fs::perms>(wrong));
    expect_refused(check("a"), Errc::usage, "/a.key: others can read it; its rights must be 0600");
  }
  fs::permissions(file("a.key"), fs::perms::owner_read);
  EXPECT_TRUE(check("a"));
}

TEST_F(Checking, TheGroupMayReadAKeyThatRootHandsOverAndNobodyElses) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can hand over";
  constexpr int nobody = 65534, other = 1;
  const gid_t group = ::getegid();
  fs::permissions(folder(), static_cast<fs::perms>(0755));
  const auto as_nobody = [&](int owner, int rights) {
    EXPECT_EQ(::chown(file("a.key").c_str(), static_cast<uid_t>(owner), nobody), 0);
    fs::permissions(file("a.key"), static_cast<fs::perms>(rights));
    EXPECT_EQ(::setegid(nobody), 0);
    EXPECT_EQ(::seteuid(nobody), 0);
    const Status checked = check("a");
    EXPECT_EQ(::seteuid(0), 0);
    EXPECT_EQ(::setegid(group), 0);
    return checked;
  };
  EXPECT_TRUE(as_nobody(0, 0640));
  EXPECT_TRUE(as_nobody(nobody, 0600));
  expect_refused(as_nobody(0, 0660), Errc::usage, "/a.key: others can read it; its rights must be 0640");
  expect_refused(as_nobody(0, 0644), Errc::usage, "/a.key: others can read it; its rights must be 0640");
  expect_refused(as_nobody(nobody, 0640), Errc::usage, "/a.key: others can read it; its rights must be 0600");
  expect_refused(as_nobody(other, 0640), Errc::usage, "/a.key: belongs to another user");
}

TEST_F(Checking, TheAuthoritysOwnFilesAreNoNode) {
  expect_refused(check("ca"), Errc::usage, "/ca.pem: is not a certificate of a node");
  expect_refused(check_node(file("b.pem"), file("a.pem"), file("a.key")), Errc::usage,
                 "/b.pem: is not a certificate of an authority");
}

TEST_F(Checking, CertificatesMadeElsewhereAreTakenIfTheyServeBothWays) {
  made_elsewhere("rsa:2048", "subjectAltName=DNS:d\n");
  EXPECT_TRUE(check("d"));
  made_elsewhere("rsa:2048", "extendedKeyUsage=serverAuth\n");
  expect_refused(check("d"), Errc::usage, "/d.pem: is not a certificate of a node: it must be for both");
  made_elsewhere("rsa:1024", "subjectAltName=DNS:d\n");
  expect_refused(check("d"), Errc::usage, "/d.pem: cannot be used with ");
}

class Finding : public Checking {
 protected:
  void SetUp() override {
    Checking::SetUp();
    fs::create_directory(file("node"));
    for (const char* name : {"ca.pem", "a.pem", "a.key"}) copy(name, std::string("node/") + name);
  }
  static Status status(const Result<NodeCertificate>& found) {
    return found ? Status(success()) : Status(found.error());
  }
};

TEST_F(Finding, TheOnlyNodeOfAFolderIsFound) {
  const auto found = node_certificate_in(file("node"));
  ASSERT_TRUE(found);
  EXPECT_EQ(found.value().authority, file("node/ca.pem"));
  EXPECT_EQ(found.value().certificate, file("node/a.pem"));
  EXPECT_EQ(found.value().key, file("node/a.key"));
  EXPECT_TRUE(check_node(found.value()));
  copy("b.pem", "node/b.pem");  // without a key it is nobody's here
  EXPECT_EQ(node_certificate_in(file("node")).value().certificate, file("node/a.pem"));
}

TEST_F(Finding, NoneAndSeveralAreNamed) {
  expect_refused(status(node_certificate_in(folder())), Errc::usage, ": holds the certificates of several nodes: a, b");
  EXPECT_EQ(node_certificate_in(folder(), "b").value().key, file("b.key"));
  expect_refused(status(node_certificate_in(folder(), "c")), Errc::usage, "/c.pem: is missing");
  expect_refused(status(node_certificate_in(folder(), "../a")), Errc::usage, "'../a' cannot be the name of a node");
  fs::remove(file("node/a.key"));
  expect_refused(status(node_certificate_in(file("node"))), Errc::usage, "/a.key: is missing");
  copy("a.key", "node/a.key");
  fs::remove(file("node/ca.pem"));
  expect_refused(status(node_certificate_in(file("node"))), Errc::usage, "/ca.pem: is missing");
  fs::remove(file("node/a.pem"));
  expect_refused(status(node_certificate_in(file("node"))), Errc::usage,
                 ": holds no certificate of a node: the files NAME.pem and NAME.key are missing");
  expect_refused(status(node_certificate_in(file("none"))), Errc::io, "/none: cannot be read");
}

}  // namespace
}  // namespace tessera
