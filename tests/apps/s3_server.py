"""A server that speaks S3 as far as readers and writers need it, and checks signatures. Source: AWS, "Create a signed AWS
API request"; "Uploading and copying objects using multipart upload"."""
import datetime
import hashlib
import hmac
import re
import secrets
import urllib.parse
from xml.sax.saxutils import escape

from object_server import Answer, ObjectServer


def refusal(status, code, headers=None):
    return Answer(status, headers or {}, f"<?xml version='1.0'?><Error><Code>{code}</Code></Error>".encode())


class S3Server(ObjectServer):
    """Objects by name "bucket/key". `keys`: the secret of each access key. `token`: what requests must bring along.
    `buckets`: those that exist beside those of the objects. `refuse(request)` may answer before anything is done. `uploads`
    has what has begun in parts: its name, and the parts by their numbers."""

    part_bytes_min = 5 << 20  # of all parts but the last

    def __init__(self, objects, keys, region="us-east-1", token=None, public=(), page=1000, buckets=(), conditions=True):
        super().__init__(objects)
        self.buckets, self.conditions, self.uploads, self.refuse = set(buckets), conditions, {}, lambda request: None
        self.keys, self.region, self.token, self.public, self.page = keys, region, token, set(public), page
        self.payers = []

    def signature(self, handler, given, sent):
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
        payload = handler.headers.get("x-amz-content-sha256")
        if payload != hashlib.sha256(sent).hexdigest():  # Amazon wants this header of every signed request
            raise ValueError("the digest is not that of what is sent")
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

    def gate(self, handler, request):
        name = urllib.parse.unquote(handler.path.split("?")[0].lstrip("/"))
        self.payers.append(handler.headers.get("x-amz-request-payer"))
        given = dict(re.findall(r"(\w+)=([^,\s]+)", handler.headers.get("Authorization", "")))
        if given:
            try:
                if given["Credential"].split("/")[0] not in self.keys:
                    return refusal(403, "InvalidAccessKeyId")
                if self.signature(handler, given, request.sent) != given["Signature"]:
                    return refusal(403, "SignatureDoesNotMatch")
            except LookupError:
                return refusal(400, "AuthorizationHeaderMalformed", {"x-amz-bucket-region": self.region})
            except ValueError:
                return refusal(403, "SignatureDoesNotMatch")
            if self.token and handler.headers.get("x-amz-security-token") != self.token:
                return refusal(403, "InvalidToken")
        elif name.split("/")[0] not in self.public:
            return refusal(403, "AccessDenied")
        refused = self.refuse(request)
        if refused is not None:
            return refused
        query = dict(urllib.parse.parse_qsl(request.query, keep_blank_values=True))
        return self.listing(name.split("/")[0], query) if query.get("list-type") == "2" else None

    def change(self, request):
        query = dict(urllib.parse.parse_qsl(request.query, keep_blank_values=True))
        with self.lock:
            if request.name.split("/")[0] not in self.buckets | {name.split("/")[0] for name in self.objects}:
                return refusal(404, "NoSuchBucket")
            if "uploadId" in query and self.uploads.get(query["uploadId"], {}).get("name") != request.name:
                return refusal(404, "NoSuchUpload")
            if request.method == "POST" and "uploads" in query:
                upload = secrets.token_hex(8) + "+/="  # as a parameter, it is to be encoded
                self.uploads[upload] = {"name": request.name, "parts": {}}
                return Answer(200, {}, f"<InitiateMultipartUploadResult><UploadId>{upload}</UploadId></InitiateMultipartUploadResult>".encode())
            if request.method == "PUT" and "uploadId" in query:
                self.uploads[query["uploadId"]]["parts"][int(query["partNumber"])] = request.sent
                return Answer(200, {"ETag": f'"{hashlib.md5(request.sent).hexdigest()}"'}, b"")
            if request.method == "POST":
                return self.complete(request, query["uploadId"])
            if request.method == "DELETE" and "uploadId" in query:
                del self.uploads[query["uploadId"]]
                return Answer(204, {}, b"")
            if request.method == "DELETE":
                self.objects.pop(request.name, None)
                return Answer(204, {}, b"")
            if "If-None-Match" in request.headers:
                if not self.conditions:
                    return refusal(501, "NotImplemented")
                if request.name in self.objects:
                    return refusal(412, "PreconditionFailed")
            self.objects[request.name] = request.sent
            return Answer(200, {"ETag": f'"{hashlib.md5(request.sent).hexdigest()}"'}, b"")

    def complete(self, request, upload):
        parts = self.uploads[upload]["parts"]
        told = [(int(number), tag) for number, tag in re.findall(
            r"<Part><PartNumber>(\d+)</PartNumber><ETag>([^<]*)</ETag></Part>", request.sent.decode())]
        if told != [(number, f'"{hashlib.md5(parts[number]).hexdigest()}"') for number in sorted(parts)] or not told:
            return refusal(400, "InvalidPart")
        bodies = [parts[number] for number, _ in told]
        if any(len(body) < self.part_bytes_min for body in bodies[:-1]):
            return refusal(400, "EntityTooSmall")
        self.objects[request.name] = b"".join(bodies)
        del self.uploads[upload]
        return Answer(200, {}, b"<CompleteMultipartUploadResult><ETag></ETag></CompleteMultipartUploadResult>")

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
