// Far objects without a network: addresses, credentials, listings, and what is kept of an object.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <random>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "src/base/files/descriptor.h"
#include "src/base/files/temporary.h"
#include "src/base/files/whole_file.h"
#include "src/base/option.h"
#include "src/input/bytes/far_source.h"
#include "src/input/bytes/objects.h"
#include "src/input/remote/kept_pages.h"
#include "src/input/remote/kept_source.h"
#include "src/input/remote/permits.h"
#include "src/input/remote/remote_objects.h"
#include "src/input/remote/s3.h"
#include "src/input/remote/s3_listing.h"
#include "src/input/remote/transfers.h"
#include "src/input/remote/url.h"

namespace tessera::remote {
namespace {

TEST(Objects, AreNamesWithAScheme) {
  for (const char* name : {"https://h/a.las", "S3://b/k", "a+b-1.c://x", "http://"}) EXPECT_TRUE(names_object(name));
  for (const char* name : {"a.las", "://x", "1a://x", "a b://x", "folder/http://x", "", "C:\\a"})
    EXPECT_FALSE(names_object(name)) << name;
}

TEST(Objects, AreRefusedByAProcessThatWasNotToldHow) {
  const auto refused = open_object("https://host/a.las?signature=SECRET", {});
  ASSERT_TRUE(refused.has_error());
  EXPECT_EQ(refused.error().code, Errc::usage);
  EXPECT_EQ(refused.error().where, "an input begins with https://, but this process reads files only");
}

TEST(Addresses, AreCheckedAndShownWithoutSecrets) {
  const auto url = parse_url("HTTPS://Host.example:8443/a b/c.las?X-Amz-Signature=SECRET#part");
  ASSERT_TRUE(url);
  EXPECT_EQ(url.value().scheme, "https");
  EXPECT_EQ(url.value().host, "host.example");
  EXPECT_EQ(url.value().shown, "HTTPS://Host.example:8443/a b/c.las");
  EXPECT_NE(url.value().address.find("/a%20b/c.las?X-Amz-Signature=SECRET"), std::string::npos);
  EXPECT_EQ(url.value().address.find('#'), std::string::npos);
  EXPECT_EQ(parse_url("http://[::1]:80/a").value().host, "::1");
  EXPECT_EQ(without_secrets("https://me:secret@host/a.las?b"), "https://host/a.las");
  for (const char* wrong : {"ftp://h/a", "https://", "https://me@h/a", "https://me:secret@h/a", "https://h:99999/a",
                            "file:///etc/passwd", "gopher://h/a"}) {
    const auto refused = parse_url(wrong);
    ASSERT_TRUE(refused.has_error()) << wrong;
    EXPECT_EQ(refused.error().code, Errc::usage);
    EXPECT_EQ(refused.error().where.find("secret"), std::string::npos);
  }
}

TEST(S3, AddressesHaveTheBucketInTheHostUnlessThereIsAnEndpointOrAPoint) {
  const auto address = [](const char* name, const S3Access& access) {
    return s3_address(name, access).value().address;
  };
  const S3Access amazon{.endpoint = {}, .region = "eu-west-3", .signing = {}};
  EXPECT_EQ(address("s3://bucket/a/b.laz", amazon), "https://bucket.s3.eu-west-3.amazonaws.com/a/b.laz");
  EXPECT_EQ(address("s3://buck.et/a/b.laz", amazon), "https://s3.eu-west-3.amazonaws.com/buck.et/a/b.laz");
  const S3Access other{.endpoint = "http://127.0.0.1:9000/", .region = "us-east-1", .signing = {}};
  EXPECT_EQ(address("s3://bucket/a b+\xC3\xBC.laz", other), "http://127.0.0.1:9000/bucket/a%20b%2B%C3%BC.laz");
  for (const char* wrong : {"s3://", "s3:///a", "s3://UPPER/a", "s3://ab/a", "s3://a@b.c/a", "s3://host:80/a"})
    EXPECT_TRUE(s3_address(wrong, amazon).has_error()) << wrong;
}

TEST(Addresses, HaveAPortAndAPathThatCanBeCompared) {
  const auto url = parse_url("https://h/a/../b/./c%20d").value();
  EXPECT_EQ(url.port + url.path, "443/b/c%20d");
  EXPECT_EQ(parse_url("http://h").value().port + parse_url("http://h").value().path, "80/");
  EXPECT_EQ(parse_url("http://0x7f.1/").value().host, "127.0.0.1");
}

TEST(Permits, AreWholeSegmentsOfOneServer) {
  const auto permits = Permits::parse({"https://Host.example/open", "http://10.0.0.5:9000/", "https://host/a%20b/",
                                       "https://host/one.laz", "s3://bucket/block/", "s3://all"});
  ASSERT_TRUE(permits) << permits.error().where;
  const auto allowed = [&](const std::string& address) {
    return (address.starts_with("s3://") ? permits.value().check_s3(address)
                                         : permits.value().check_address(address, address))
        .has_value();
  };
  for (const char* below :
       {"https://host.example/open", "https://HOST.example:443/open/a.laz?x=/../..", "https://host.example/open/",
        "https://host.example/closed/../open/a.laz", "http://10.0.0.5:9000/any/where", "https://host/a b/c",
        "https://host/%61%20b/c", "https://host/one.laz", "s3://bucket/block/a.laz", "s3://bucket/block/",
        "s3://bucket/block/a b%2e/c", "s3://all/", "s3://all", "s3://all/a/b"})
    EXPECT_TRUE(allowed(below)) << below;
  for (const char* beside : {"https://host.example/opened/a.laz",
                             "https://host.example/",
                             "https://host.example/open/../closed/a.laz",
                             "http://host.example/open/a.laz",
                             "https://host.example:8443/open/a.laz",
                             "https://host.example./open/a.laz",
                             "https://host.example.evil/open/a.laz",
                             "https://evil/open/a.laz",
                             "https://evil/https://host.example/open/",
                             "https://host.example@evil/open/a.laz",
                             "https://me@host.example/open/a.laz",
                             "https://host/one.laz2",
                             "http://10.0.0.5/any",
                             "http://10.0.0.50:9000/any",
                             "ftp://host.example/open/a.laz",
                             "file:///open/a.laz",
                             "s3://bucket/blocks/a.laz",
                             "s3://bucket/a.laz",
                             "s3://bucket",
                             "s3://bucket2/block/a.laz",
                             "s3://all/../bucket/a.laz",
                             "s3://bucket/block/../a.laz",
                             "s3://bucket/block/./a.laz",
                             "https://",
                             "//host.example/open",
                             ""})
    EXPECT_FALSE(allowed(beside)) << beside;
}

TEST(Permits, RefusePathsThatServersReadInSeveralWays) {
  const auto permits = Permits::parse({"https://host/"});
  ASSERT_TRUE(permits);
  for (const char* path : {"a%2f..%2fb", "a%5cb", "a\\b", "a%252e%252e", "a%00b", "a%0ab", "a%2", "a%zz", "a/..;/b",
                           "a/..;x=1/b", "a/%2e%2e;/b", "a/.;/b"})
    EXPECT_EQ(permits.value().check_address(std::string("https://host/") + path, "x").error().code, Errc::usage)
        << path;
  // libcurl may resolve these or not; below a folder neither reading may lead out of it.
  const auto folder = Permits::parse({"https://host/open/"});
  for (const char* path : {"open/%2e%2e/closed/a", "open/%2E%2E/closed", "open/.%2e/closed", "open/a/%2e%2e/%2e%2e/b"})
    EXPECT_TRUE(folder.value().check_address(std::string("https://host/") + path, "x").has_error()) << path;
}

TEST(Permits, RefusePrefixesThatAreNone) {
  for (const char* wrong : {"host/open", "ftp://host/", "https://me:secret@host/", "https://host/?a", "https://host/#a",
                            "s3://", "s3:///a", "https://host/a%2fb", "https://host/..;/", "", "/srv/lidar"}) {
    const auto refused = Permits::parse({"https://good/", wrong});
    ASSERT_TRUE(refused.has_error()) << wrong;
    EXPECT_EQ(refused.error().code, Errc::usage);
    EXPECT_EQ(refused.error().where.find("secret"), std::string::npos);
  }
  EXPECT_TRUE(Permits::parse({}));
}

sockaddr_storage address_of(const std::string& number) {
  sockaddr_storage address{};
  auto& v4 = reinterpret_cast<sockaddr_in&>(address);
  auto& v6 = reinterpret_cast<sockaddr_in6&>(address);
  address.ss_family = AF_INET;
  if (::inet_pton(AF_INET, number.c_str(), &v4.sin_addr) == 1) return address;
  address.ss_family = AF_INET6;
  EXPECT_EQ(::inet_pton(AF_INET6, number.c_str(), &v6.sin6_addr), 1) << number;
  return address;
}

TEST(Permits, KnowAddressesThatLeadInward) {
  const auto inward = [](const std::string& number) {
    const auto address = address_of(number);
    EXPECT_EQ(address_number(reinterpret_cast<const sockaddr&>(address)), number);
    return leads_inward(reinterpret_cast<const sockaddr&>(address));
  };
  for (const char* number : {"127.0.0.1",
                             "127.255.0.9",
                             "0.0.0.0",
                             "0.1.2.3",
                             "169.254.169.254",
                             "169.254.0.1",
                             "100.100.100.200",
                             "168.63.129.16",
                             "192.0.0.192",
                             "224.0.0.1",
                             "255.255.255.255",
                             "240.0.0.1",
                             "::1",
                             "::",
                             "fe80::1",
                             "febf::1",
                             "fec0::1",
                             "ff02::1",
                             "fd00:ec2::254",
                             "::ffff:127.0.0.1",
                             "::ffff:169.254.169.254",
                             "::ffff:0.0.0.0",
                             "::127.0.0.1",
                             "64:ff9b::a9fe:a9fe",
                             "64:ff9b:1::7f00:1",
                             "2002:7f00:1::",
                             "2002:a9fe:a9fe::1",
                             "::ffff:0:7f00:1"})
    EXPECT_TRUE(inward(number)) << number;
  for (const char* number :
       {"10.0.0.5", "192.168.1.1", "172.16.0.1", "128.0.0.1", "169.253.0.1", "8.8.8.8", "100.100.100.201",
        "2001:db8::1", "fd00::1", "fc00::1", "::ffff:10.0.0.5", "64:ff9b::808:808", "2002:808:808::1"})
    EXPECT_FALSE(inward(number)) << number;
  sockaddr_storage local{};
  local.ss_family = AF_UNIX;
  EXPECT_TRUE(leads_inward(reinterpret_cast<const sockaddr&>(local)));
}

TEST(Permits, KnowTheNumberOfAnAddress) {
  const auto is = [](const char* host, const char* number) {
    const auto address = address_of(number);
    return is_number_of(host, reinterpret_cast<const sockaddr&>(address));
  };
  EXPECT_TRUE(is("127.0.0.1", "127.0.0.1"));
  EXPECT_TRUE(is("::1", "::1"));
  EXPECT_TRUE(is("0:0::1", "::1"));
  EXPECT_TRUE(is("::ffff:127.0.0.1", "127.0.0.1"));
  for (const char* host : {"localhost", "127.0.0.2", "::1", "", "127.1"}) EXPECT_FALSE(is(host, "127.0.0.1")) << host;
}

class Credentials : public testing::Test {
 protected:
  Result<S3Access> find(const S3Options& options = {}) {
    variables_["HOME"] = folder_.path().string();
    return find_s3_access(options, [this](const char* name) {
      const auto found = variables_.find(name);
      return found == variables_.end() ? nullptr : found->second.c_str();
    });
  }
  void write(const char* name, std::string_view text) {
    ASSERT_TRUE(make_directories(folder_.path() / ".aws"));
    ASSERT_TRUE(write_whole(folder_.path() / ".aws" / name, text));
  }
  TemporaryFolder folder_ = TemporaryFolder::make().value();
  std::map<std::string, std::string> variables_;
};

TEST_F(Credentials, ComeFromVariablesThenFromTheProfile) {
  EXPECT_EQ(find().error().code, Errc::usage);
  EXPECT_EQ(find({.anonymous = true}).value().signing, nullptr);
  write("credentials",
        "[default]\r\naws_access_key_id = A\r\naws_secret_access_key = B\r\n[x]\naws_access_key_id=X\n"
        "aws_secret_access_key=Y==\naws_session_token=Z\n");
  write("config",
        "[default]\nregion=eu-north-1\naws_session_token = of another key\n[profile x]\n"
        "endpoint_url = http://e\n nested = 1\n");
  auto found = find();
  ASSERT_TRUE(found);
  EXPECT_EQ(found.value().signing->key + found.value().signing->secret + found.value().signing->token, "AB");
  EXPECT_EQ(found.value().region, "eu-north-1");
  variables_ = {{"AWS_PROFILE", "x"}, {"AWS_REGION", "r"}};
  found = find();
  EXPECT_EQ(found.value().signing->key + found.value().signing->secret + found.value().signing->token, "XY==Z");
  EXPECT_EQ(found.value().region + found.value().endpoint, "rhttp://e");
  variables_["AWS_ACCESS_KEY_ID"] = "K", variables_["AWS_SECRET_ACCESS_KEY"] = "S";
  EXPECT_EQ(find().value().signing->key, "K");
  EXPECT_EQ(find({.profile = "default"}).value().signing->key, "A");
  EXPECT_EQ(find({.profile = "nobody"}).error().code, Errc::usage);
  EXPECT_EQ(find({.endpoint = "https://o"}).value().endpoint, "https://o");
}

Result<S3Page> page_of(std::string_view xml) { return parse_s3_page(std::as_bytes(std::span(xml))); }

TEST(S3, ListingsAreParsedOrRefused) {
  const auto page = page_of(
      "<?xml version='1.0'?><ListBucketResult xmlns='u'><IsTruncated>true</IsTruncated><Contents><Key>a%20b/%C3%BC.laz"
      "</Key><Owner><Key>no</Key></Owner></Contents><CommonPrefixes><Prefix>c/</Prefix></CommonPrefixes>"
      "<NextContinuationToken>T&amp;1</NextContinuationToken></ListBucketResult>");
  ASSERT_TRUE(page);
  EXPECT_EQ(page.value().keys, std::vector<std::string>{"a b/\xC3\xBC.laz"});
  EXPECT_EQ(page.value().next, "T&1");
  EXPECT_TRUE(page.value().folders);
  for (const char* wrong :
       {"", "<a/>", "<ListBucketResult>", "<html><body>sign in</body></html>",
        "<ListBucketResult><IsTruncated>true</IsTruncated></ListBucketResult>",
        "<!DOCTYPE x [<!ENTITY a 'b'>]><ListBucketResult><Contents><Key>&a;</Key></Contents></ListBucketResult>"})
    EXPECT_TRUE(page_of(wrong).has_error()) << wrong;
}

// An object in memory that counts what is asked for.
class Counted : public RangeReader {
 public:
  explicit Counted(std::size_t bytes) : bytes_(bytes) {
    std::mt19937 random(1);
    for (auto& byte : bytes_) byte = static_cast<std::byte>(random());
  }
  const std::string& name() const override { return name_; }
  std::uint64_t size() const override { return bytes_.size(); }
  std::int64_t modified_ns() const override { return 0; }
  Result<std::vector<std::vector<std::byte>>> read(std::span<const ByteRange> ranges) const override {
    if (fails) return error(Errc::io, "far: does not answer");
    std::vector<std::vector<std::byte>> got;
    for (const auto& range : ranges) {
      EXPECT_LT(range.begin, range.end);
      EXPECT_LE(range.end, size());
      got.emplace_back(bytes_.begin() + static_cast<std::ptrdiff_t>(range.begin),
                       bytes_.begin() + static_cast<std::ptrdiff_t>(range.end));
      asked += range.end - range.begin;
    }
    requests += ranges.size();
    return got;
  }
  std::vector<std::byte> begin(std::size_t bytes) const {
    return {bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(std::min(bytes, bytes_.size()))};
  }
  bool is(std::uint64_t at, std::span<const std::byte> bytes) const {
    return std::equal(bytes.begin(), bytes.end(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  mutable std::atomic<std::uint64_t> asked{0}, requests{0};
  std::atomic<bool> fails{false};

 private:
  std::string name_ = "far";
  std::vector<std::byte> bytes_;
};

struct Far {
  explicit Far(std::size_t bytes, std::shared_ptr<KeptPages> pages = std::make_shared<KeptPages>("", 0)) {
    auto made = std::make_unique<Counted>(bytes);
    object = made.get();
    source = keep_source(std::move(made), object->begin(16384), std::move(pages), {}).value();
  }
  bool reads(std::uint64_t at, std::size_t bytes) const {
    std::vector<std::byte> got(bytes);
    return source->read(at, got).has_value() && object->is(at, got);
  }
  Counted* object = nullptr;
  std::shared_ptr<const FarSource> source;
};

TEST(KeptSource, GivesTheBytesOfTheObjectFromManyThreads) {
  for (const std::size_t size : {1u, 4095u, 4096u, 4097u, 20'000u, 3'000'001u}) {
    const Far far(size);
    std::vector<std::jthread> threads;
    for (unsigned t = 0; t < 4; ++t)
      threads.emplace_back([&far, size, t] {
        std::mt19937_64 random(t);
        for (int i = 0; i < 200; ++i) {
          const auto at = random() % (size + 1);
          EXPECT_TRUE(far.reads(at, static_cast<std::size_t>(random() % (size - at + 1))));
        }
      });
    threads.clear();
    EXPECT_LE(far.object->asked, size) << "bytes were fetched twice";
  }
}

TEST(KeptSource, FetchesNothingAfterItWasBrought) {
  const Far far(10'000'000);
  const std::vector<ByteRange> ranges{
      {9'000'000, 9'400'000}, {50'000, 50'001}, {60'000, 70'000}, {9'999'999, 10'000'000}};
  const auto shared = share(far.source);
  ASSERT_TRUE(bring_near(*shared, ranges));
  EXPECT_EQ(far.object->requests, 3u) << "near ranges are one request";
  const std::uint64_t asked = far.object->asked;
  EXPECT_LT(asked, 460'000u);
  for (const auto& range : ranges)
    EXPECT_TRUE(far.reads(range.begin, static_cast<std::size_t>(range.end - range.begin)));
  EXPECT_EQ(far.object->asked, asked);
}

TEST(KeptSource, FetchesAheadOfReadsInOrder) {
  const Far far(30'000'000);
  for (std::uint64_t at = 0; at + 65'536 <= 30'000'000; at += 65'536) ASSERT_TRUE(far.reads(at, 65'536));
  EXPECT_LE(far.object->asked, 30'000'000u);
  EXPECT_LT(far.object->requests, 60u);
}

TEST(KeptSource, ReadsMoreThanIsKept) {
  const auto pages = std::make_shared<KeptPages>("", 0);  // the least: 64 MiB, for both objects
  const Far one(70'000'000, pages), other(20'000'000, pages);
  EXPECT_TRUE(one.reads(0, 70'000'000));
  EXPECT_TRUE(other.reads(0, 20'000'000));
  EXPECT_TRUE(one.reads(0, 70'000'000));
}

TEST(KeptSource, AsksAgainAfterAnError) {
  const Far far(1'000'000);
  far.object->fails = true;
  std::vector<std::byte> got(100'000);
  EXPECT_EQ(far.source->read(500'000, got).error().where, "far: does not answer");
  EXPECT_EQ(bring_near(*far.source, std::vector<ByteRange>{{0, 1'000'000}}).error().code, Errc::io);
  far.object->fails = false;
  EXPECT_TRUE(far.reads(500'000, 100'000));
  EXPECT_EQ(far.source->read(999'999, got).error().code, Errc::bad_input);
}

// A server with one answer for each request, which keeps what it was sent.
class TellingServer {
 public:
  explicit TellingServer(std::string answer) : answer_(std::move(answer)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t bytes = sizeof address;
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), bytes), 0);
    EXPECT_EQ(::listen(socket_.get(), 64), 0);
    EXPECT_EQ(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&address), &bytes), 0);
    port_ = std::to_string(ntohs(address.sin_port));
    thread_ = std::jthread([this] { serve(); });
  }
  TellingServer(const TellingServer&) = delete;
  TellingServer& operator=(const TellingServer&) = delete;
  ~TellingServer() { ::shutdown(socket_.get(), SHUT_RDWR); }

  std::string url(const std::string& host, const std::string& path) const {
    return "http://" + host + ":" + port_ + path;
  }
  int connections() const { return connections_; }

 private:
  void serve() {
    while (true) {
      const FileHandle peer(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      if (peer.get() < 0) return;
      ++connections_;
      std::string request;
      char buffer[4096];
      while (request.find("\r\n\r\n") == std::string::npos) {
        const auto got = ::recv(peer.get(), buffer, sizeof buffer, 0);
        if (got <= 0) break;
        request.append(buffer, static_cast<std::size_t>(got));
      }
      EXPECT_EQ(::send(peer.get(), answer_.data(), answer_.size(), MSG_NOSIGNAL), static_cast<ssize_t>(answer_.size()));
    }
  }

  std::string answer_, port_;
  std::atomic<int> connections_{0};
  FileHandle socket_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  std::jthread thread_;
};

std::shared_ptr<const Permits> permits_of(const std::vector<std::string>& prefixes) {
  return std::make_shared<const Permits>(Permits::parse(prefixes).value());
}

std::string opened(const std::vector<std::string>& prefixes, const std::string& name) {
  const auto objects = remote_objects({.permits = permits_of(prefixes)});
  const auto got = objects->open(name, {});
  return got.has_value() ? "opened" : got.error().where;
}

const char* const ten_bytes =
    "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes 0-9/10\r\nContent-Length: 10\r\nConnection: close\r\n\r\n"
    "0123456789";

// What a name means may change between a check and the connection. So the address of the connection counts.
TEST(Permits, HoldForTheAddressOfTheConnection) {
  const TellingServer server(ten_bytes);
  const std::string by_name = server.url("localhost", "/a.xyz"), by_number = server.url("127.0.0.1", "/a.xyz");
  EXPECT_EQ(opened({server.url("127.0.0.1", "/")}, by_number), "opened");
  EXPECT_EQ(server.connections(), 1);
  const std::string refused = opened({server.url("localhost", "/"), server.url("127.0.0.1", "/")}, by_name);
  EXPECT_NE(refused.find("its name leads to "), std::string::npos) << refused;
  EXPECT_EQ(refused.find("tries"), std::string::npos) << refused;
  for (const char* host : {"0.0.0.0", "[::ffff:127.0.0.1]", "127.0.0.2"})
    EXPECT_NE(opened({server.url("127.0.0.1", "/")}, server.url(host, "/a.xyz")), "opened") << host;
  EXPECT_EQ(server.connections(), 1);
}

TEST(Permits, HoldWhateverAProxyWouldDo) {
  const TellingServer server(ten_bytes);
  ASSERT_EQ(::setenv("http_proxy", server.url("127.0.0.1", "").c_str(), 1), 0);
  const std::string refused = opened({"http://localhost:1/"}, "http://localhost:1/a.xyz");
  ::unsetenv("http_proxy");
  EXPECT_NE(refused, "opened");
  EXPECT_EQ(server.connections(), 0);
}

TEST(Permits, HoldForEachRedirect) {
  for (const char* location : {"http://127.0.0.1:1/a", "http://localhost:1/a", "http://169.254.169.254/latest/", "/b",
                               "/open/../b", "//127.0.0.1:1/open/a", "/open/%2e%2e/b"}) {
    const TellingServer server("HTTP/1.1 302 Found\r\nContent-Length: 0\r\nConnection: close\r\nLocation: " +
                               std::string(location) + "\r\n\r\n");
    const std::string refused = opened({server.url("127.0.0.1", "/open/")}, server.url("127.0.0.1", "/open/a.xyz"));
    EXPECT_NE(refused.find("the server leads to "), std::string::npos) << refused;
    EXPECT_EQ(server.connections(), 1) << location;
  }
}

// A server that takes connections and never answers.
class SilentServer {
 public:
  SilentServer() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t bytes = sizeof address;
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), bytes), 0);
    EXPECT_EQ(::listen(socket_.get(), 64), 0);
    EXPECT_EQ(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&address), &bytes), 0);
    address_ = "http://127.0.0.1:" + std::to_string(ntohs(address.sin_port)) + "/a.las";
  }
  const std::string& address() const { return address_; }

 private:
  FileHandle socket_{::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  std::string address_;
};

TEST(Transfers, GiveUpASilentServer) {
  const SilentServer server;
  Transfers transfers({.connect_ms = 1000, .slow_bytes = 1024, .slow_s = 1, .whole_s = 1});
  const std::vector<HttpRequest> requests(20,
                                          HttpRequest{.address = server.address(), .range = "0-9", .bytes_max = 10});
  const auto replies = transfers.run(requests, {});
  ASSERT_TRUE(replies);
  for (const auto& reply : replies.value()) {
    EXPECT_EQ(reply.status, 0);
    EXPECT_TRUE(reply.passing);
    EXPECT_NE(reply.failure, "");
  }
}

TEST(Transfers, StopWhenTheyAreTold) {
  const SilentServer server;
  Transfers transfers(Patience{});
  const std::vector<HttpRequest> requests(20,
                                          HttpRequest{.address = server.address(), .range = "0-9", .bytes_max = 10});
  std::stop_source stop;
  std::jthread other([&] { stop.request_stop(); });
  EXPECT_EQ(transfers.run(requests, stop.get_token()).error().code, Errc::interrupted);
}

TEST(Transfers, SayWhyThereIsNoAnswer) {
  Transfers transfers(Patience{});
  const auto replies = transfers.run({{.address = "http://127.0.0.1:1/", .range = "0-9", .bytes_max = 10},
                                      {.address = "file:///etc/passwd", .range = "0-9", .bytes_max = 10}},
                                     {});
  ASSERT_TRUE(replies);
  EXPECT_TRUE(replies.value()[0].passing);
  for (const auto& reply : replies.value()) EXPECT_NE(reply.failure, "");
  EXPECT_FALSE(replies.value()[1].passing);
  EXPECT_TRUE(replies.value()[1].body.empty());
}

}  // namespace
}  // namespace tessera::remote
