#include "src/cluster/certs/certificates.h"

#include <sys/stat.h>

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "tests/certs/certs_testing.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

class Making : public Certificates {};

TEST_F(Making, AnAuthorityIsWhatOthersTakeForOne) {
  CertificateOptions options;
  options.cluster = "lyon";
  ASSERT_TRUE(make_authority(folder(), options));
  EXPECT_EQ(names_in(folder()), (std::set<std::string>{"ca.pem", "ca.key"}));
  EXPECT_EQ(openssl("verify -x509_strict -CAfile ca.pem ca.pem"), "ca.pem: OK\n");
  const std::string text = openssl("x509 -in ca.pem -noout -text");
  for (const char* part : {"Basic Constraints: critical\n                CA:TRUE, pathlen:0\n",
                           "Key Usage: critical\n                Certificate Sign, CRL Sign\n",
                           "Subject Key Identifier", "CN = lyon", "ASN1 OID: prime256v1", "ecdsa-with-SHA256"})
    EXPECT_PRED_FORMAT2(testing::IsSubstring, part, text);
  EXPECT_EQ(openssl("pkey -in ca.key -check -noout"), "Key is valid\n");
}

TEST_F(Making, ANodeIsServerAndClientOfItsAuthority) {
  ASSERT_TRUE(make_authority(folder()));
  ASSERT_TRUE(make_node(folder(), "node-1.example.org"));
  ASSERT_TRUE(make_node(folder(), "10.0.0.7"));
  for (const std::string node : {"node-1.example.org", "10.0.0.7"}) {
    for (const std::string purpose : {"sslserver", "sslclient"})
      EXPECT_EQ(openssl("verify -x509_strict -CAfile ca.pem -purpose " + purpose + " " + node + ".pem"),
                node + ".pem: OK\n");
    EXPECT_EQ(openssl("x509 -in " + node + ".pem -noout -subject"), "subject=CN = " + node + "\n");
    EXPECT_TRUE(check(node));
  }
  EXPECT_EQ(openssl("x509 -in node-1.example.org.pem -noout -ext subjectAltName,extendedKeyUsage"),
            "X509v3 Extended Key Usage: \n    TLS Web Server Authentication, TLS Web Client Authentication\n"
            "X509v3 Subject Alternative Name: \n    DNS:node-1.example.org\n");
  EXPECT_PRED_FORMAT2(testing::IsSubstring, "IP Address:10.0.0.7",
                      openssl("x509 -in 10.0.0.7.pem -noout -ext subjectAltName"));
}

TEST_F(Making, KeysAndTheFolderAreForTheirOwnerAlone) {
  const mode_t mask = ::umask(0);
  const auto made = make_authority(file("new/certs/"));
  const auto node = make_node(file("new/certs"), "a");
  ::umask(mask);
  ASSERT_TRUE(made && node);
  EXPECT_EQ(rights(file("new/certs")), 0700);
  EXPECT_EQ(rights(file("new/certs/ca.key")), 0600);
  EXPECT_EQ(rights(file("new/certs/a.key")), 0600);
}

TEST_F(Making, AFolderThatOthersCanWriteIsRefused) {
  fs::permissions(folder(), fs::perms::others_write, fs::perm_options::add);
  expect_refused(make_authority(folder()), Errc::usage, ": others can write in it");
  EXPECT_EQ(names_in(folder()), std::set<std::string>());
}

TEST_F(Making, NothingThatIsThereIsReplaced) {
  ASSERT_TRUE(make_authority(folder()));
  ASSERT_TRUE(make_node(folder(), "a"));
  const std::string authority = text_of(file("ca.key")), node = text_of(file("a.key"));
  expect_refused(make_authority(folder()), Errc::usage, "/ca.pem: exists already");
  expect_refused(make_node(folder(), "a"), Errc::usage, "/a.pem: exists already");
  fs::remove(file("ca.pem"));
  fs::remove(file("a.pem"));
  expect_refused(make_authority(folder()), Errc::usage, "/ca.key: exists already");
  EXPECT_EQ(text_of(file("ca.key")), authority);
  EXPECT_EQ(text_of(file("a.key")), node);
}

TEST_F(Making, ANameThatIsNoneTouchesNoFile) {
  ASSERT_TRUE(make_authority(folder()));
  for (const std::string name : {"../x", "a/b", "", ".", "..", ".hidden", "-rf", "a b", "a,DNS:b", "ca", "gr\xc3\xbcn",
                                 "a\n", "a\t", "fe80::1", "*"})
    expect_refused(make_node(folder(), name), Errc::usage, "'" + name + "' cannot be the name of a node");
  expect_refused(make_node(folder(), std::string(65, 'a')), Errc::usage, "1 to 64");
  EXPECT_EQ(names_in(folder()), (std::set<std::string>{"ca.pem", "ca.key"}));
  EXPECT_FALSE(fs::exists(folder().parent_path() / "x.pem"));
  EXPECT_TRUE(make_node(folder(), std::string(64, 'a')));
  CertificateOptions options;
  options.cluster = "two words";
  expect_refused(make_authority(file("other"), options), Errc::usage, "'two words' cannot be the name of a cluster");
  EXPECT_FALSE(fs::exists(file("other")));
}

TEST_F(Making, DaysAreFromNowAndNoNodeOutlivesItsAuthority) {
  const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  CertificateOptions options;
  options.now = now;
  ASSERT_TRUE(make_authority(file("ten"), options));
  ASSERT_TRUE(make_node(file("ten"), "two", options));
  EXPECT_EQ(valid_until(file("ten/ca.pem")).value(), now + 3650 * day);
  EXPECT_EQ(valid_until(file("ten/two.pem")).value(), now + 730 * day);
  options.days = 36500;
  ASSERT_TRUE(make_node(file("ten"), "long", options));
  EXPECT_EQ(valid_until(file("ten/long.pem")).value(), now + 3650 * day);
  for (const int days : {0, -1, 36501}) {
    options.days = days;
    EXPECT_EQ(make_authority(file("more"), options).error().code, Errc::usage);
    EXPECT_EQ(make_node(file("ten"), "more", options).error().code, Errc::usage);
  }
  EXPECT_FALSE(fs::exists(file("more")));
}

TEST_F(Making, ACenturyIsADateToo) {
  CertificateOptions options;
  options.now = std::chrono::sys_days(std::chrono::year(2026) / 1 / 31);
  options.days = 36500;
  ASSERT_TRUE(make_authority(folder(), options));
  EXPECT_EQ(openssl("x509 -in ca.pem -noout -startdate -enddate -dateopt iso_8601"),
            "notBefore=2026-01-30 23:00:00Z\nnotAfter=2126-01-07 00:00:00Z\n");
  EXPECT_EQ(date_text(valid_until(file("ca.pem")).value()), "2126-01-07 00:00 UTC");
}

TEST_F(Making, NoTwoSerialNumbersAreEqual) {
  ASSERT_TRUE(make_authority(folder()));
  std::set<std::string> serials{openssl("x509 -in ca.pem -noout -serial")};
  for (const std::string node : {"a", "b", "c"}) {
    ASSERT_TRUE(make_node(folder(), node));
    const std::string serial = openssl("x509 -in " + node + ".pem -noout -serial");
    EXPECT_GT(serial.size(), std::string("serial=\n").size() + 24) << serial;
    EXPECT_TRUE(serials.insert(serial).second);
  }
}

TEST_F(Making, ANodeNeedsAnAuthorityThatIsValidWithItsKey) {
  expect_refused(make_node(folder(), "a"), Errc::usage, ": holds no authority of a cluster: there is no ca.pem");
  expect_refused(make_node(file("none"), "a"), Errc::io, "/none: ");
  ASSERT_TRUE(make_authority(folder(), made(-3651 * day)));
  expect_refused(make_node(folder(), "a"), Errc::usage, "/ca.pem: expired on ");
  ASSERT_TRUE(make_authority(file("other")));
  fs::copy_file(file("other/ca.pem"), file("ca.pem"), fs::copy_options::overwrite_existing);
  expect_refused(make_node(folder(), "a"), Errc::usage, "/ca.key: does not belong to ");
  fs::permissions(file("other/ca.key"), fs::perms::group_read, fs::perm_options::add);
  expect_refused(make_node(file("other"), "a"), Errc::usage, "/ca.key: others can read it; its rights must be 0600");
  fs::remove(file("other/ca.key"));
  expect_refused(make_node(file("other"), "a"), Errc::io, "/ca.key: ");
  EXPECT_EQ(names_in(file("other")), std::set<std::string>{"ca.pem"});
}

TEST_F(Making, ANodeMayBeCalledLikeItsCluster) {
  ASSERT_TRUE(make_authority(folder()));
  ASSERT_TRUE(make_node(folder(), "tessera"));
  EXPECT_TRUE(check("tessera"));
}

}  // namespace
}  // namespace tessera
