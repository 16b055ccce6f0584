"""A server that speaks S3 as far as readers need it, and checks signatures. Source: AWS, "Create a signed AWS API request"."""
import datetime
import hashlib
import hmac
import re
import urllib.parse
from xml.sax.saxutils import escape

from object_server import Answer, ObjectServer


def refusal(status, code, headers=None):
    return Answer(status, headers or {}, f"<?xml version='1.0'?><Error><Code>{code}</Code></Error>".encode())


class S3Server(ObjectServer):
    """Objects by name "bucket/key". `keys`: the secret of each access key. `token`: what requests must bring along."""

    def __init__(self, objects, keys, region="us-east-1", token=None, public=(), page=1000):
        super().__init__(objects)
        self.keys, self.region, self.token, self.public, self.page = keys, region, token, set(public), page
        self.payers = []

    def signature(self, handler, given):
        """The signature of a request, made from what the request says of itself."""
        path, _, query = handler.path.partition("?")
        if path != urllib.parse.quote(urllib.parse.unquote(path), safe="/-_.~"):
            raise ValueError("the path is not encoded as it is signed")
        pairs = sorted(pair if "=" in pair else pair + "=" for pair in query.split("&") if pair)
        signed = given["SignedHeaders"].split(";")
        if signed != sorted(signed) or not {"host", "x-amz-date"} <= set(signed):
            raise ValueError("headers that must be signed are not")
        unsigned = {name.lower() for name in handler.headers if name.lower().startswith("x-amz-")} - set(signed)
        if unsigned:
            raise ValueError(f"not signed: {unsigned}")
        heads = "".join(f"{name}:{' '.join(handler.headers[name].split())}\n" for name in signed)
        payload = handler.headers.get("x-amz-content-sha256") or hashlib.sha256(b"").hexdigest()
        canonical = "\n".join((handler.command, path, "&".join(pairs), heads, ";".join(signed), payload))
        key, date, region, service, last = given["Credential"].split("/")
        if (region, service, last) != (self.region, "s3", "aws4_request"):
            raise LookupError(region)
        stamp = handler.headers["x-amz-date"]
        sent = datetime.datetime.strptime(stamp, "%Y%m%dT%H%M%SZ").replace(tzinfo=datetime.timezone.utc)
        if not stamp.startswith(date) or abs((datetime.datetime.now(datetime.timezone.utc) - sent).total_seconds()) > 900:
            raise ValueError("at another time")
        secret = ("AWS4" + self.keys[key]).encode()
        for part in (date, region, service, last):
            secret = hmac.new(secret, part.encode(), hashlib.sha256).digest()
        text = "\n".join(("AWS4-HMAC-SHA256", stamp, f"{date}/{region}/s3/aws4_request", hashlib.sha256(canonical.encode()).hexdigest()))
        return hmac.new(secret, text.encode(), hashlib.sha256).hexdigest()

    def gate(self, handler):
        name = urllib.parse.unquote(handler.path.split("?")[0].lstrip("/"))
        self.payers.append(handler.headers.get("x-amz-request-payer"))
        given = dict(re.findall(r"(\w+)=([^,\s]+)", handler.headers.get("Authorization", "")))
        if given:
            try:
                if given["Credential"].split("/")[0] not in self.keys:
                    return refusal(403, "InvalidAccessKeyId")
                if self.signature(handler, given) != given["Signature"]:
                    return refusal(403, "SignatureDoesNotMatch")
            except LookupError:
                return refusal(400, "AuthorizationHeaderMalformed", {"x-amz-bucket-region": self.region})
            except ValueError:
                return refusal(403, "SignatureDoesNotMatch")
            if self.token and handler.headers.get("x-amz-security-token") != self.token:
                return refusal(403, "InvalidToken")
        elif name.split("/")[0] not in self.public:
            return refusal(403, "AccessDenied")
        query = dict(urllib.parse.parse_qsl(handler.path.partition("?")[2], keep_blank_values=True))
        return self.listing(name.split("/")[0], query) if query.get("list-type") == "2" else None

    def listing(self, bucket, query):
        prefix, after = query["prefix"], query.get("continuation-token", "")
        keys = sorted(name.partition("/")[2] for name in self.objects if name.startswith(bucket + "/" + prefix))
        below = [key for key in keys if "delimiter" in query and "/" in key[len(prefix):]]
        keys = [key for key in keys if key not in below and key > after]
        page, more = keys[:self.page], keys[self.page:]
        quoted = [escape(urllib.parse.quote(key, safe="/")) for key in page]
        folders = {prefix + key[len(prefix):].split("/")[0] + "/" for key in below}
        return Answer(200, {"Content-Type": "application/xml"}, (
            "<?xml version='1.0' encoding='UTF-8'?><ListBucketResult xmlns='http://s3.amazonaws.com/doc/2006-03-01/'>"
            f"<IsTruncated>{'true' if more else 'false'}</IsTruncated><EncodingType>url</EncodingType>"
            + "".join(f"<Contents><Key>{key}</Key><Size>1</Size></Contents>" for key in quoted)
            + "".join(f"<CommonPrefixes><Prefix>{escape(folder)}</Prefix></CommonPrefixes>" for folder in folders)
            + (f"<NextContinuationToken>{escape(page[-1])}</NextContinuationToken>" if more else "")
            + "</ListBucketResult>").encode())
