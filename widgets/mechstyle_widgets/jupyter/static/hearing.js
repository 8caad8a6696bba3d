// A model whose script came after anywidget's two seconds refuses all the kernel says. It is found out by telling it nothing: then what
// is said goes past anywidget, and what was missed is asked for.
async function hearAgain(model) {
  const found = await model.widget_manager.get_model(model.get("own"));
  if (!found.comm) return; // a page without a kernel has nothing to hear
  const nothing = { content: { data: { method: "" } }, buffers: [] };
  await found._handle_comm_msg(nothing).catch(() => {
    const plain = Object.getPrototypeOf(Object.getPrototypeOf(found))._handle_comm_msg;
    found.comm.on_msg(plain.bind(found));
    found.comm.send({ method: "request_state" }, {});
  });
}

const hears = (initialize) => (given) => {
  hearAgain(given.model).catch(() => {}); // a host with models of its own sort, which hear by its own means
  return initialize?.(given);
};

// What a script says, in the language the kernel speaks; `{}` is filled in.
const speaking = (model) => (english, ...given) => given.reduce((text, one) => text.replace("{}", one), model.get("said")[english] ?? english);
