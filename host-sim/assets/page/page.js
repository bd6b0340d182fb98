(() => {
  'use strict';
  document.documentElement.classList.add('js');

  const save = (blob, name) => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  };

  // Four times the size: 93 mm at 384 dpi.
  const png = async text => {
    const image = new Image();
    image.src = `data:image/svg+xml,${encodeURIComponent(text)}`;
    await image.decode();
    const canvas = Object.assign(document.createElement('canvas'), { width: 4 * image.width, height: 4 * image.height });
    const context = canvas.getContext('2d');
    context.fillStyle = '#fff';
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    return new Promise(done => canvas.toBlob(done, 'image/png'));
  };

  const tools = figure => {
    const text = new XMLSerializer().serializeToString(figure.querySelector('.static svg'));
    const [toggle, svg, bitmap] = figure.querySelectorAll('.tools button');
    toggle.onclick = () => toggle.setAttribute('aria-pressed', figure.classList.toggle('as-svg'));
    svg.onclick = () => save(new Blob([text], { type: 'image/svg+xml' }), `${figure.id}.svg`);
    bitmap.onclick = async () => save(await png(text), `${figure.id}.png`);
  };

  for (const figure of document.querySelectorAll('figure')) {
    const data = JSON.parse(figure.querySelector('script').textContent);
    figures.draw(figure.querySelector('.plots'), data, figure.id);
    tools(figure);
  }
})();
