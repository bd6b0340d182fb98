(() => {
  'use strict';
  document.documentElement.classList.add('js');

  const tools = figure => {
    const drawing = figure.querySelector('.static svg');
    const [toggle, download] = figure.querySelectorAll('.tools button');
    toggle.onclick = () => toggle.setAttribute('aria-pressed', figure.classList.toggle('as-svg'));
    download.onclick = () => {
      const text = new XMLSerializer().serializeToString(drawing);
      const link = document.createElement('a');
      link.href = URL.createObjectURL(new Blob([text], { type: 'image/svg+xml' }));
      link.download = `${figure.id}.svg`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    };
  };

  for (const figure of document.querySelectorAll('figure')) {
    const data = JSON.parse(figure.querySelector('script').textContent);
    figures.draw(figure.querySelector('.plots'), data, figure.id);
    tools(figure);
  }
})();
