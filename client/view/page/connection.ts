// Requests to the server of the page over one WebSocket. Replies come in the order of the requests.

import { decode, type ResultMessage } from "./result";

/** An error of the service, or of the connection. */
export class ServiceError extends Error {
  constructor(
    readonly kind: string,
    message: string,
    readonly at = "",
  ) {
    super(message);
  }
}

/** A reply: JSON, or a head with sections. */
export type Reply = Record<string, unknown> & { sections?: unknown };

interface Waiting {
  resolve(reply: Reply | ResultMessage): void;
  reject(error: Error): void;
  progress: ((line: string) => void) | undefined;
}

/** Pause before a lost connection is opened again, ms. */
const RETRY_MS = 1000;

/** The connection to the server. It opens itself again after it was lost. */
export class Connection {
  private socket: WebSocket | undefined;
  private opening: Promise<WebSocket> | undefined;
  private waiting = new Map<number, Waiting>();
  private next = 1;
  /** Called when the connection is lost (false) and when it is there again (true). */
  onState: (isOpen: boolean) => void = () => undefined;

  /** Sends a request and waits for the reply. */
  async ask(request: Record<string, unknown>): Promise<Reply> {
    return (await this.send(request)) as Reply;
  }

  /** Sends a request whose reply is a binary message. */
  async askResult(request: Record<string, unknown>): Promise<ResultMessage> {
    return (await this.send(request)) as ResultMessage;
  }

  /** Sends a file with a head, and reports the lines of its progress. */
  async sendFile(head: Record<string, unknown>, contents: ArrayBuffer, progress: (line: string) => void): Promise<Reply> {
    const socket = await this.open();
    const id = this.next++;
    const text = new TextEncoder().encode(JSON.stringify({ ...head, id }));
    const length = new Uint8Array(new Uint32Array([text.length]).buffer);
    const reply = this.wait(id, progress);
    socket.send(new Blob([length, text, contents]));
    return (await reply) as Reply;
  }

  private async send(request: Record<string, unknown>): Promise<Reply | ResultMessage> {
    const socket = await this.open();
    const id = this.next++;
    const reply = this.wait(id, undefined);
    socket.send(JSON.stringify({ ...request, id }));
    return reply;
  }

  private wait(id: number, progress: ((line: string) => void) | undefined): Promise<Reply | ResultMessage> {
    return new Promise((resolve, reject) => this.waiting.set(id, { resolve, reject, progress }));
  }

  private open(): Promise<WebSocket> {
    if (this.socket?.readyState === WebSocket.OPEN) return Promise.resolve(this.socket);
    this.opening ??= this.connect().finally(() => (this.opening = undefined));
    return this.opening;
  }

  private connect(): Promise<WebSocket> {
    const address = new URL("socket", location.href);
    address.protocol = "ws:";
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    return new Promise((resolve, reject) => {
      socket.onopen = () => {
        this.socket = socket;
        this.onState(true);
        resolve(socket);
      };
      socket.onmessage = (event) => this.receive(event.data as string | ArrayBuffer);
      socket.onclose = () => {
        const lost = new ServiceError("lost", "shatter view does not run any more; start it again and open the address that it prints");
        this.fail(lost);
        reject(lost);
        if (this.socket === socket) {
          this.socket = undefined;
          this.onState(false);
          setTimeout(() => this.open().catch(() => undefined), RETRY_MS);
        }
      };
    });
  }

  private fail(error: Error): void {
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    for (const one of waiting) one.reject(error);
  }

  private receive(data: string | ArrayBuffer): void {
    const message = typeof data === "string" ? (JSON.parse(data) as Reply) : decode(data);
    const head = (typeof data === "string" ? message : (message as ResultMessage).head) as Record<string, unknown>;
    const id = head["id"] as number;
    const one = this.waiting.get(id);
    if (head["reply"] === "progress") {
      one?.progress?.(String(head["line"]));
      return;
    }
    this.waiting.delete(id);
    const error = head["error"] as { kind: string; message: string; at: string } | undefined;
    if (error && id === 0) this.fail(new ServiceError(error.kind, error.message));
    else if (error) one?.reject(new ServiceError(error.kind, error.message, error.at));
    else one?.resolve(message as Reply);
  }
}
